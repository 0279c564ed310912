#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# empty_debian.sh FOLDER: makes an empty Debian 12 in FOLDER (debootstrap, minbase), copies the committed sources into it,
# does there what docs/python.md says, runs the five lines of its first drape, and prints the time of each step. Needs
# root, debootstrap and the network; FOLDER takes 2 GB. A FOLDER of an earlier run is used again, and compiles what has changed.
# MIRROR names the mirror (default: that of debootstrap).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -ne 1 ]; then
  echo "usage: scripts/empty_debian.sh FOLDER" >&2
  exit 2
fi
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "empty_debian.sh needs root and debootstrap (apt install debootstrap)" >&2
  exit 2
fi
mkdir -p "$1"
system=$(cd "$1" && pwd)
TIMEFORMAT='  %R s, of which processor time %U + %S s'

step() {
  local name=$1
  shift
  echo "$name"
  time "$root/scripts/quietly.sh" "$@"
}

# inside COMMAND: runs it in the system, which sees no variables and no files of this one but /proc and /dev.
inside() {
  unshare -m bash -c '
    mount --make-rprivate / && mount --bind /proc "$0/proc" && mount --bind /dev "$0/dev" &&
    exec chroot "$0" env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin bash -ec "cd /root/selvedge; $1"
  ' "$system" "$1"
}
export -f inside
export system

if [ ! -x "$system/usr/bin/apt-get" ]; then
  step "An empty Debian 12" debootstrap --variant=minbase bookworm "$system" ${MIRROR:+"$MIRROR"}
fi
cp /etc/resolv.conf "$system/etc/resolv.conf"
mkdir -p "$system/root/selvedge"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git -C "$root" archive HEAD | tar -x -C "$work"
(cd "$work" && find . -type f) | while read -r file; do # a file that has not changed keeps its time
  cmp -s "$work/$file" "$system/root/selvedge/$file" || install -D -p "$work/$file" "$system/root/selvedge/$file"
done
awk '/^```python/ { on = 1; next } /^```/ && on { exit } on' "$root/docs/python.md" >"$system/root/first_drape.py"

step "Packages" bash -c 'inside "scripts/install_dependencies.sh python"'
step "pip install ." bash -c 'inside "python3 -m venv --system-site-packages venv && venv/bin/pip install ."'
echo "The first drape of docs/python.md"
time inside "venv/bin/python /root/first_drape.py" | tee "$system/root/first_drape.txt"
grep -q '^clean ' "$system/root/first_drape.txt"
