# SPDX-License-Identifier: MIT
"""Build back end of the Python package (PEP 517): runs CMake and packs the wheel.

It needs a C++20 compiler, CMake and the libraries that CMake finds, and no Python package but NumPy and
pybind11 of the system, so that pip downloads nothing. Settings, such as
`pip install . -C cmake="-DSELVEDGE_FCL=OFF"`:
    cmake      further options of the configuration, separated by blanks
    build      folder of the build, which a second installation uses again (default: build/pip)
    jobs       compilers at a time (default: number of cores)
"""

import base64
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def _version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(selvedge VERSION ([0-9.]+)", text)
    if found is None:
        raise RuntimeError("CMakeLists.txt names no version")
    return found.group(1)


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def _metadata():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return (
        "Metadata-Version: 2.1\nName: selvedge\n"
        f"Version: {_version()}\n"
        "Summary: Exact cloth collision, and cloth that never passes through anything\n"
        "License: MIT\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
        f"Description-Content-Type: text/markdown\n\n{readme}"
    )


def _wheel_file():
    return f"Wheel-Version: 1.0\nGenerator: selvedge_build\nRoot-Is-Purelib: false\nTag: {_tag()}\n"


def _run(*command):
    print("+", shlex.join(map(str, command)), flush=True)
    try:
        subprocess.run([str(part) for part in command], check=True)
    except FileNotFoundError:
        raise SystemExit(
            f"selvedge: {command[0]} is not installed; docs/python.md lists the packages"
        ) from None
    except subprocess.CalledProcessError as error:
        raise SystemExit(
            f"selvedge: {command[0]} failed with {error.returncode}; its messages are above, and "
            "docs/python.md lists the packages that the build needs"
        ) from None


def _build(settings, prefix):
    """Builds the module and installs the package into a folder."""
    build = Path(settings.get("build", ROOT / "build" / "pip"))
    configure = [
        "cmake",
        "-S",
        ROOT,
        "-B",
        build,
        "-DCMAKE_BUILD_TYPE=Release",
        "-DSELVEDGE_UNITY=ON",
        "-DSELVEDGE_PYTHON=ON",
        "-DSELVEDGE_APPS=OFF",
        "-DSELVEDGE_INSTALL=OFF",
        "-DSELVEDGE_PYTHON_DIR=.",
        f"-DPython_EXECUTABLE={sys.executable}",
    ]
    if not (build / "CMakeCache.txt").exists() and shutil.which("ninja"):
        configure += ["-G", "Ninja"]
    jobs = settings.get("jobs", str(os.cpu_count() or 1))
    _run(*configure, *shlex.split(settings.get("cmake", "")))
    _run("cmake", "--build", build, "--target", "selvedge_python", "--parallel", jobs)
    _run("cmake", "--install", build, "--component", "python", "--prefix", prefix, "--strip")


def _digest(data):
    raw = hashlib.sha256(data).digest()
    return "sha256=" + base64.urlsafe_b64encode(raw).rstrip(b"=").decode()


def _pack(wheel, files):
    """Writes a wheel from a dict of names and contents."""
    info = f"selvedge-{_version()}.dist-info"
    files = dict(files)
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = _wheel_file().encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join(f"{name},{_digest(data)},{len(data)}\n" for name, data in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory() as prefix:
        _build(config_settings or {}, Path(prefix))
        package = Path(prefix) / "selvedge"
        files = {f"selvedge/{f.name}": f.read_bytes() for f in sorted(package.iterdir())}
    name = f"selvedge-{_version()}-{_tag()}.whl"
    _pack(Path(wheel_directory) / name, files)
    return name


def build_sdist(sdist_directory, config_settings=None):
    stem = f"selvedge-{_version()}"

    def wanted(entry):
        parts = Path(entry.name).parts[1:]
        hidden = any(p in ("__pycache__", ".git") for p in parts)
        return None if hidden or parts[:1] in (("build",), ("out",), ("shared",)) else entry

    with tempfile.TemporaryDirectory() as folder:
        info = Path(folder) / "PKG-INFO"
        info.write_text(_metadata(), encoding="utf-8")
        with tarfile.open(Path(sdist_directory) / f"{stem}.tar.gz", "w:gz") as archive:
            archive.add(ROOT, stem, filter=wanted)
            archive.add(info, f"{stem}/PKG-INFO")
    return f"{stem}.tar.gz"


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    info = Path(metadata_directory) / f"selvedge-{_version()}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(_metadata(), encoding="utf-8")
    (info / "WHEEL").write_text(_wheel_file(), encoding="utf-8")
    return info.name
