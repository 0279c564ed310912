#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# install_dependencies.sh [lean|meshes|test|python|release|platform|windows|docs|clang|bits|arm64]: installs the missing packages of a set by apt.
# Waits while another program holds the lock of apt.
#   lean    packages to build the program (the default); pictures need libpng, the exact check needs GMP
#   meshes  lean, and assimp, which reads bodies in formats other than OBJ, PLY and OFF
#   test    meshes, and packages for the tests, the benchmarks, the format check and the adapters; chromium opens the pages
#           of `view` and `compare`, ffmpeg joins animations, snakemake spreads jobs
#   python  meshes, and packages for `pip install .`
#   release   python, and packages for scripts/release.sh
#   platform  packages for the build and the tests in scripts/platforms.sh
#   windows   packages for apps/windows/build.sh and check.sh
#   docs    packages for scripts/docs.sh
#   clang   lean, and packages for scripts/fuzz.sh
#   bits    clang, and packages for scripts/same_bits.sh
#   arm64   a cross compiler for 64-bit Arm and its libraries, for scripts/same_bits.sh
# Without root it prints the packages to install and exits with 1. On a system without dpkg it prints the requirements and
# exits with 0.
# install_dependencies.sh names SET: prints the packages of a set.
# install_dependencies.sh apt ARGUMENTS...: runs apt-get silently; if it fails, prints the end of its output.
set -euo pipefail

# While another program holds a lock of apt or dpkg, waits for up to 15 minutes and reports it. apt-get itself can wait for
# the lock of dpkg but not for that of the package lists.
apt_get() (
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  patience=${SELVEDGE_APT_PATIENCE:-900} # s
  waiting=
  export DEBIAN_FRONTEND=noninteractive LC_ALL=C
  while true; do
    status=0
    apt-get -o DPkg::Lock::Timeout=60 "$@" >"$log" 2>&1 || status=$?
    if [ "$status" -eq 0 ]; then exit 0; fi
    if ! grep -qE 'Could not get lock|Unable to lock|Unable to acquire the dpkg' "$log" || [ "$SECONDS" -ge "$patience" ]; then
      tail -n 60 "$log" >&2
      echo "failed with $status: apt-get $*" >&2
      exit "$status"
    fi
    if [ -z "$waiting" ]; then
      echo "Another program is installing packages; waiting for it, at most $((patience / 60)) minutes"
      waiting=yes
    fi
    sleep 2
  done
)
if [ "${1:-}" = apt ]; then
  shift
  apt_get "$@"
  exit
fi

lean=(g++ cmake ninja-build libeigen3-dev libtbb-dev nlohmann-json3-dev libcli11-dev libfmt-dev
      libpng-dev libgmp-dev)
meshes=(libassimp-dev)
adapters=(libfcl-dev libccd-dev libembree-dev libosmesa6-dev libpagmo-dev)
platform=("${adapters[@]}" libgtest-dev libcgal-dev libbullet-dev python3-dev python3-numpy python3-pytest pybind11-dev)
test=("${platform[@]}" clang-format mypy chromium ffmpeg snakemake)
python=("${meshes[@]}" python3-dev python3-numpy python3-pip python3-venv pybind11-dev)
release=("${python[@]}" "${adapters[@]}" dpkg-dev patchelf)
clang=(clang libclang-rt-14-dev)
bits=("${clang[@]}" musl-dev qemu-user-static)
arm64=(g++-aarch64-linux-gnu libtbb-dev:arm64 libfmt-dev:arm64 libpng-dev:arm64 libgmp-dev:arm64)
windows=(g++-mingw-w64-x86-64-posix libz-mingw-w64-dev m4 dpkg-dev cmake ninja-build zip unzip wine64 libeigen3-dev nlohmann-json3-dev libcli11-dev
         libfmt-dev)
docs=(doxygen python3-sphinx python3-myst-parser python3-breathe furo libjs-katex)

set=${1:-lean}
if [ "$set" = names ]; then set=${2:-}; fi
case "$set" in
  lean) wanted=("${lean[@]}") ;;
  meshes) wanted=("${lean[@]}" "${meshes[@]}") ;;
  test) wanted=("${lean[@]}" "${meshes[@]}" "${test[@]}") ;;
  python) wanted=("${lean[@]}" "${python[@]}") ;;
  release) wanted=("${lean[@]}" "${release[@]}") ;;
  platform) wanted=("${lean[@]}" "${meshes[@]}" "${platform[@]}") ;;
  windows) wanted=("${windows[@]}") ;;
  docs) wanted=("${docs[@]}") ;;
  clang) wanted=("${lean[@]}" "${clang[@]}") ;;
  bits) wanted=("${lean[@]}" "${bits[@]}") ;;
  arm64) wanted=("${lean[@]}" "${arm64[@]}") ;;
  *) echo "install_dependencies.sh: unknown set '$set': say lean, meshes, test, python, release, platform, windows, docs, clang, bits or arm64" >&2; exit 2 ;;
esac
if [ "${1:-}" = names ]; then
  echo "${wanted[*]}"
  exit
fi

if ! command -v dpkg-query >/dev/null; then
  echo "No Debian packages here; the build needs what Debian calls: ${wanted[*]}"
  exit 0
fi

# A package of two architectures has two states.
is_installed() { [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null || true)" == installed* ]]; }

missing=()
for package in "${wanted[@]}"; do
  is_installed "$package" || missing+=("$package")
done
if [ "${#missing[@]}" -eq 0 ]; then
  exit 0
fi
if [ "$(id -u)" -ne 0 ]; then
  echo "Missing packages; install them and start again:" >&2
  echo "  sudo apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi

echo "Installing ${missing[*]}"
if [[ " ${missing[*]} " == *:arm64\ * ]]; then dpkg --add-architecture arm64; fi
apt_get update -q
apt_get install -qy --no-install-recommends "${missing[@]}"
