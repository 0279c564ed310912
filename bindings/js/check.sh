#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check.sh PACKAGE.tgz LIBRARY: installs the packed npm package into an empty folder and compares the bits of its results, of
# a garment and of six scenes after six frames, with those of the native library libselvedge.so; prints the processor time of each scene, in a second run.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
package=$(realpath "$1") library=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
data=$(realpath "$here/../../data")
scenes=()
for name in cloth_on_sphere flag hysteresis incline plate_2 finite_elements; do scenes+=("$data/scenes/$name.json"); done
cd "$work"
npm install --silent --offline --no-audit --no-fund "$package"
cp "$here/check.mjs" .
node check.mjs "$data/patterns/flared_skirt.json" "$data/bodies/mannequin_arms_out.ply" "${scenes[@]}" >here.txt 2>here_seconds.txt
python3 "$here/check.py" "$library" "$data/patterns/flared_skirt.json" "$data/bodies/mannequin_arms_out.ply" "${scenes[@]}" >native.txt 2>native_seconds.txt
cmp here.txt native.txt
echo "$(wc -l <here.txt) lines of results, $(wc -w <here.txt) numbers: the same bits as the native library"
join here_seconds.txt native_seconds.txt | awk '
  function row(name, first, here, native) { printf "%-24s WebAssembly %6.3f s (first run %6.3f s), native %6.3f s, ratio %.2f\n", name, here, first, native, here / native }
  { row($1, $2, $3, $5); first += $2; here += $3; native += $5 }
  END { row("all", first, here, native) }'
