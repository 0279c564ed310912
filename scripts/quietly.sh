#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# quietly.sh COMMAND...: runs the command silently; if it fails, prints the end of its output.
set -euo pipefail
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
"$@" >"$log" 2>&1 || status=$?
if [ "$status" -ne 0 ]; then
  tail -n 60 "$log" >&2
  echo "failed with $status: $*" >&2
fi
exit "$status"
