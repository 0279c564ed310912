#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_format.sh [--fix]: lists every source that clang-format (14, as in Debian 12) would change. --fix: changes them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mapfile -t folders < <(awk '/^[a-z]/ { print $1 }' cmake/rooms.txt)
sources() {
  find "${folders[@]}" \( -name '*.h' -o -name '*.cpp' -o -name '*.inc' \) ! -name '*_generated.cpp' -print0 | sort -z
}
if [ "${1:-}" = --fix ]; then
  sources | xargs -0 clang-format -i
  exit 0
fi
faulty=$(sources | xargs -0 clang-format --dry-run 2>&1 | sed -n 's/^\([^:]*\):[0-9]*:[0-9]*: warning.*/\1/p' | sort -u)
if [ -n "$faulty" ]; then
  printf '%s\n' "$faulty" >&2
  echo "check_format.sh: $(wc -l <<<"$faulty") sources are not formatted; scripts/check_format.sh --fix formats them" >&2
  exit 1
fi
echo "$(sources | tr -cd '\0' | wc -c) sources are formatted"
