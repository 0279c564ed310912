# SPDX-License-Identifier: MIT
"""The Python code of README.md and docs/python.md runs as it is printed."""

import re

import pytest

from conftest import ROOT, sheet

DOCUMENTS = ["README.md", "docs/python.md"]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_code_of_a_document_runs(document, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    x, t = sheet()
    names = {"x0": x + [0, 0, 0.1], "x1": x - [0, 0, 0.1], "y": x, "triangles": t, "body_triangles": t}
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(), re.M | re.S)
    assert blocks
    for block in blocks:
        exec(compile(block, document, "exec"), names)
        if "table" in names:
            assert len(names.pop("table")) > 0
    assert "clean" in capsys.readouterr().out.split()
