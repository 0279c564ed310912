#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# apt_get.sh ARGUMENTS...: runs apt-get silently; if it fails, prints the end of its output. While another program holds
# a lock of apt or dpkg, the script waits for up to 15 minutes and reports it. apt-get itself can wait for the lock of
# dpkg but not for that of the package lists.
set -euo pipefail
log=$(mktemp)
trap 'rm -f "$log"' EXIT
patience=${SELVEDGE_APT_PATIENCE:-900} # s
waiting=
export DEBIAN_FRONTEND=noninteractive LC_ALL=C
while true; do
  status=0
  apt-get -o DPkg::Lock::Timeout=60 "$@" >"$log" 2>&1 || status=$?
  if [ "$status" -eq 0 ]; then exit 0; fi
  if ! grep -qE 'Could not get lock|Unable to lock|Unable to acquire the dpkg' "$log" || [ "$SECONDS" -ge "$patience" ]; then
    tail -n 60 "$log" >&2
    echo "failed with $status: apt-get $*" >&2
    exit "$status"
  fi
  if [ -z "$waiting" ]; then
    echo "Another program is installing packages; waiting for it, at most $((patience / 60)) minutes"
    waiting=yes
  fi
  sleep 2
done
