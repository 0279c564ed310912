#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check.sh files|addon [PROGRAM [PICTURE]]: tests in Blender without a display. Blender (apt install blender, 400 MB)
# is not part of any set of scripts/install_dependencies.sh.
#   files  runs a scene in the formats that Blender reads and imports them: the .glb file at every frame, with the names,
#          texture coordinates, normals and colours of its pieces, the last .obj file, and the .pc2 and .mdd caches on their
#          base mesh by a mesh-cache modifier. Every vertex must be within 1e-7 m of the PLY frame.
#          Debian's Blender cannot read USD; tests/run/exchange_test.cpp reads those files.
#   addon  tests the add-on bindings/blender/selvedge_cloth.py from end to end: bakes cloth over a moving and a resting collider, with
#          pins, from an object that is turned and scaled; checks the cache, the refusals and the removal; renders PICTURE
#          (.png) if it is named.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
check=${1:-}
program=$(realpath "${2:-build/release/apps/selvedge}")
picture=${3:+$(realpath -m "$3")}
if [ "$check" != files ] && [ "$check" != addon ]; then
  echo "usage: bindings/blender/check.sh files|addon [PROGRAM [PICTURE]]" >&2
  exit 2
fi
if ! command -v blender >/dev/null; then
  echo "check.sh: there is no blender; install it (apt install blender)" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ "$check" = files ]; then
  cat >"$work/scene.json" <<'SCENE'
{"name": "files",
 "geometry": [
  {"name": "lower", "size": [0.4, 0.3], "cells": [12, 9], "transformation": {"translation": [0.01, 0.02, 0.211]}},
  {"name": "upper", "size": [0.4, 0.3], "cells": [12, 9], "transformation": {"translation": [0.01, 0.02, 0.222]}}],
 "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.2, "resolution": 24}}],
 "time": {"frames": 30},
 "output": {"formats": ["gltf", "mdd", "obj", "pc2"]}}
SCENE
  "$program" run "$work/scene.json" --no-pictures --out "$work/result" >/dev/null
  HOME=$work blender -b --factory-startup --python-exit-code 1 --python bindings/blender/check.py -- "$work/result" 2>&1 |
    grep -v '^Blender\|^Info\|^$\|Data are loaded\|glTF import finished'
else
  HOME=$work SELVEDGE_PROGRAM=$program blender -b --factory-startup --python-exit-code 1 \
    --python bindings/blender/addon_check.py -- "$work" ${picture:+"$picture"} 2>&1 | grep '^check:\|Error\|error\|assert' || true
  test -f "$work/passed"
fi
