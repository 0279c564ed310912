#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# readme_commands.sh SOURCE_DIR PROGRAM_DIR: runs the commands of README.md and docs/program.md, in this order, in an
# empty folder beside the repository's data, and fails with the first that fails. A ```sh block is run if the line
# before it is the marker that names this script.
set -euo pipefail
source_dir=$1
program_dir=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
commands=$(awk '/^```$/ { inside = 0 } inside { print } /^```sh$/ { inside = marked } { marked = /readme_commands.sh -->/ }' \
  "$source_dir/README.md" "$source_dir/docs/program.md")
count=$(grep -c '^selvedge ' <<<"$commands" || true)
# Every command of the program has a sample.
commands_of_program=$("$program_dir/selvedge" --help | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 }')
if [ -z "$commands_of_program" ]; then
  echo "selvedge --help lists no commands" >&2
  exit 1
fi
for name in $commands_of_program; do
  if ! grep -q "^selvedge $name" <<<"$commands"; then
    echo "selvedge $name has no sample in README.md or docs/program.md" >&2
    exit 1
  fi
done
ln -s "$source_dir/data" "$work/data"
cd "$work"
export PATH=$program_dir:$PATH
bash -euxo pipefail -c "$commands"
echo "$count commands of the README and docs/program.md ran"
