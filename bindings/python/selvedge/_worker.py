# SPDX-License-Identifier: MIT
"""The process of a comparison: `python -I _worker.py plan|run`, with the request as JSON on standard
input. Writes one JSON object a line: {"done", "all"} or {"fault", "is_value"}.

A comparison copies its process for each run, and a copy has only one of the threads. This process
therefore loads neither NumPy nor the package, only the compiled half.
"""

import hashlib
import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import _core  # type: ignore  # noqa: E402


def _say(**message: object) -> None:
    print(json.dumps(message), flush=True)


def _build() -> str:
    """Names the build: times and bits of two builds must not be mixed."""
    with open(_core.__file__, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:16]


def main() -> None:
    request = json.load(sys.stdin)
    try:
        if sys.argv[1] == "plan":
            _core.plan_compare(request, request["out"], _build())
        else:
            _core.run_compare(
                request["out"], _build(), lambda done, everything: _say(done=done, all=everything)
            )
    except (ValueError, RuntimeError) as error:
        _say(fault=str(error), is_value=isinstance(error, ValueError))


main()
