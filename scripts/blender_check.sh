#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# blender_check.sh [PROGRAM]: runs a scene in the formats that Blender reads and imports them in Blender without a
# display: the .glb file at every frame, and the .pc2 and .mdd caches on their base mesh by a mesh-cache modifier. Every
# vertex must be within 1e-6 m of the PLY frame. Blender (apt install blender, 400 MB) is not part of any set of
# scripts/install_dependencies.sh. Debian's Blender cannot read USD; tests/exchange_test.cpp reads those files.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${1:-build/release/apps/selvedge}
if ! command -v blender >/dev/null; then
  echo "blender_check.sh: there is no blender; install it (apt install blender)" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" run data/scenes/cloth_on_sphere.json --no-picture --out "$work/ball" --set time.frames=30 \
  --set 'geometry.0.cells=[20,20]' --set 'output.formats=["gltf","mdd","pc2"]' >/dev/null
HOME=$work blender -b --factory-startup --python-exit-code 1 --python scripts/blender_check.py -- "$work/ball" 2>&1 |
  grep -v '^Blender\|^Info\|^$\|Data are loaded\|glTF import finished'
