#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# readme_commands.sh SOURCE_DIR PROGRAM_DIR: runs the commands of the README that follow the marker naming this script,
# one after the other, in an empty folder beside the repository's data, and fails with the first that fails.
set -euo pipefail
source_dir=$1
program_dir=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
commands=$(awk '/readme_commands.sh -->/ { wanted = 1 } wanted && /^```$/ { exit } inside { print } wanted && /^```sh$/ { inside = 1 }' \
  "$source_dir/README.md")
count=$(grep -c '^selvedge ' <<<"$commands" || true)
if [ "$count" -lt 4 ]; then
  echo "only $count commands found in the README" >&2
  exit 1
fi
ln -s "$source_dir/data" "$work/data"
cd "$work"
export PATH=$program_dir:$PATH
bash -euxo pipefail -c "$commands"
echo "$count commands of the README ran"
