# SPDX-License-Identifier: MIT
"""Build back end of the Python package (PEP 517): runs CMake and packs the wheel.

It needs a C++20 compiler, CMake and the libraries that CMake finds, and no Python package but NumPy and
pybind11 of the system, so that pip downloads nothing. Settings, such as
`pip install . -C cmake="-DSELVEDGE_FCL=OFF"`:
    cmake      further options of the configuration, separated by blanks
    build      folder of the build, which a second installation uses again (default: build/pip)
    jobs       compilers at a time (default: number of cores)
    libraries  "bundle": the wheel carries the shared libraries that it needs beside those of every system with its C
               library, with their licences (needs patchelf; Debian)

With SOURCE_DATE_EPOCH set, the same build gives the same bytes.
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
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def _version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(selvedge VERSION ([0-9.]+)", text)
    if found is None:
        raise RuntimeError("CMakeLists.txt names no version")
    return found.group(1)


def _tag(bundle=False):
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    if bundle:  # runs on every system whose C library is not older (PEP 600)
        libc = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
        platform = platform.replace("linux", f"manylinux_{libc}")
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


def _wheel_file(tag):
    return f"Wheel-Version: 1.0\nGenerator: selvedge_build\nRoot-Is-Purelib: false\nTag: {tag}\n"


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


# Libraries that every system with the C library of the tag has (PEP 600).
_OF_EVERY_SYSTEM = re.compile(r"(lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+)|ld-linux-.*|linux-vdso)\.so")


def _output(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def _bundle(package):
    """Copies the libraries that files of the package need into the package, each under its name and a part of its digest,
    so that no other library of the process is taken for it. Returns the licences of their Debian packages by file name."""
    users = [f for f in sorted(package.iterdir()) if f.suffix == ".so" or f.name == "selvedge-assimp"]
    found = {}  # name -> path, for all direct and indirect needs
    for file in users:
        for name, path in re.findall(r"^\s+(\S+) => (/\S+)", _output("ldd", file), re.MULTILINE):
            if not _OF_EVERY_SYSTEM.match(name):
                found[name] = Path(path).resolve()
    folder = package / "libraries"
    folder.mkdir()
    names, licences = {}, {}
    for name, path in sorted(found.items()):
        stem, _, version = name.partition(".so")
        names[name] = f"{stem}-{hashlib.sha256(path.read_bytes()).hexdigest()[:8]}.so{version}"
        users.append(folder / names[name])
        shutil.copy(path, users[-1])
        # dpkg knows some files of /usr/lib as those of /lib.
        owner = _output("dpkg", "-S", f"*lib/{path.parent.name}/{path.name}").partition(":")[0]
        licences[f"{owner}.txt"] = Path(f"/usr/share/doc/{owner}/copyright").read_bytes()
    for file in users:
        inside = file.parent == folder
        needed = [name for name in _output("patchelf", "--print-needed", file).split() if name in names]
        # patchelf 0.14 mixes up the arguments of several changes in one call.
        for name in needed:
            _run("patchelf", "--replace-needed", name, names[name], file)
        if inside:
            _run("patchelf", "--set-soname", file.name, file)
        _run("patchelf", "--force-rpath", "--set-rpath", "$ORIGIN" if inside else "$ORIGIN/libraries", file)
    return licences


def _digest(data):
    raw = hashlib.sha256(data).digest()
    return "sha256=" + base64.urlsafe_b64encode(raw).rstrip(b"=").decode()


def _pack(wheel, tag, files, programs=()):
    """Writes a wheel from a dict of names and contents. Those in `programs` may be executed."""
    info = f"selvedge-{_version()}.dist-info"
    files = dict(files)
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = _wheel_file(tag).encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join(f"{name},{_digest(data)},{len(data)}\n" for name, data in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    date = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))[:6]
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, date)
            entry.external_attr = (0o100755 if name in programs else 0o100644) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    settings = config_settings or {}
    bundle = settings.get("libraries") == "bundle"
    tag = _tag(bundle)
    with tempfile.TemporaryDirectory() as prefix:
        _build(settings, Path(prefix))
        package = Path(prefix) / "selvedge"
        licences = _bundle(package) if bundle else {}
        files = {f"selvedge/{f.relative_to(package)}": f.read_bytes() for f in sorted(package.rglob("*")) if f.is_file()}
    info = f"selvedge-{_version()}.dist-info"
    files |= {f"{info}/licences/{name}": text for name, text in sorted(licences.items())}
    name = f"selvedge-{_version()}-{tag}.whl"
    _pack(Path(wheel_directory) / name, tag, files, programs=("selvedge/selvedge-assimp",))
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
    (info / "WHEEL").write_text(_wheel_file(_tag((config_settings or {}).get("libraries") == "bundle")), encoding="utf-8")
    return info.name
