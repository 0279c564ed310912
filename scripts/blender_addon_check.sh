#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# blender_addon_check.sh [PROGRAM [PICTURE]]: tests the add-on blender/selvedge_cloth.py from end to end in Blender without
# a display: bakes cloth over a moving and a resting collider, with pins, from an object that is turned and scaled; checks
# the cache, the refusals and the removal; renders PICTURE (.png) if it is named. Blender (apt install blender, 400 MB) is
# not part of any set of scripts/install_dependencies.sh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=$(realpath "${1:-build/release/apps/selvedge}")
picture=${2:+$(realpath -m "$2")}
if ! command -v blender >/dev/null; then
  echo "blender_addon_check.sh: there is no blender; install it (apt install blender)" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
HOME=$work SELVEDGE_PROGRAM=$program blender -b --factory-startup --python-exit-code 1 \
  --python scripts/blender_addon_check.py -- "$work" ${picture:+"$picture"} 2>&1 | grep '^check:\|Error\|error\|assert' || true
test -f "$work/passed"
