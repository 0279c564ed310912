#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_format.sh [--fix]: compares every source with .clang-format (clang-format 14, Debian 12's), or rewrites it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
folders=(core bodies broadphase narrowphase response scene apps tests bench examples)
find "${folders[@]}" \( -name '*.h' -o -name '*.cpp' \) ! -name '*_generated.cpp' -print0 | sort -z |
  if [ "${1:-}" = --fix ]; then xargs -0 clang-format -i; else xargs -0 clang-format --dry-run -Werror; fi
