#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# install_dependencies.sh [lean|test|docs]: installs by apt what is missing, and nothing that is there.
#   lean  what the program needs to be built (the default)
#   test  that, and what the tests, the benchmarks and the format check need, with the libraries that the adapters
#         are made for
#   docs  what scripts/docs.sh makes the site with
# Without root it says what to install and ends with 1. On a system without dpkg it says what is needed and ends with 0.
set -euo pipefail

lean=(g++ cmake ninja-build libeigen3-dev libassimp-dev libtbb-dev nlohmann-json3-dev libcli11-dev libfmt-dev
      libpng-dev libgmp-dev)
test=(libgtest-dev clang-format libfcl-dev libccd-dev libcgal-dev libembree-dev libosmesa6-dev libbullet-dev
      libpagmo-dev)
docs=(doxygen python3-sphinx python3-myst-parser python3-breathe furo libjs-katex)

case "${1:-lean}" in
  lean) wanted=("${lean[@]}") ;;
  test) wanted=("${lean[@]}" "${test[@]}") ;;
  docs) wanted=("${docs[@]}") ;;
  *) echo "install_dependencies.sh: unknown set '$1': say lean, test or docs" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null; then
  echo "No Debian packages here; the build needs what Debian calls: ${wanted[*]}"
  exit 0
fi

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null || true)" = installed ]; }

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
export DEBIAN_FRONTEND=noninteractive
quietly=$(dirname "${BASH_SOURCE[0]}")/quietly.sh
"$quietly" apt-get update -q
"$quietly" apt-get install -qy --no-install-recommends "${missing[@]}"
