#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check.sh PACKAGE.tgz LIBRARY: installs the packed npm package into an empty folder and compares the bits of its results with
# those of the native library libselvedge.so.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
package=$(realpath "$1") library=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p node_modules/selvedge
tar -xf "$package" -C node_modules/selvedge --strip-components=1
cp "$here/check.mjs" .
node check.mjs >here.txt
python3 "$here/check.py" "$library" >native.txt
cmp here.txt native.txt
echo "$(wc -l <here.txt) lines of results, $(wc -w <here.txt) numbers: the same bits as the native library"
