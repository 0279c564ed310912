#!/bin/sh
# SPDX-License-Identifier: MIT
# fetch_bodies.sh: downloads the test meshes of Debian's package libcgal-demo (homer, armadillo, bear, bunny, man, ...)
# into data/fetched/. We may not redistribute them, so they are never committed. Requires Debian 12; does nothing if the
# meshes are already present.
set -eu

fail() {
  echo "fetch_bodies: $1" >&2
  exit 1
}

root=$(cd "$(dirname "$0")/.." && pwd)
target=$root/data/fetched
wanted="homer.off armadillo.off bear.off bunny00.off man.off elephant.off"

complete() {
  for mesh in $wanted; do
    [ -s "$target/$mesh" ] || return 1
  done
}

if complete; then
  echo "fetch_bodies: the meshes are already in $target"
  exit 0
fi

for tool in apt-get dpkg-deb tar gzip; do
  command -v "$tool" >/dev/null 2>&1 || fail "$tool is missing; run this on Debian or Ubuntu"
done

work=$(mktemp -d) || fail "no temporary folder could be made"
trap 'rm -rf "$work"' EXIT INT TERM
chmod 755 "$work"    # apt's own user downloads into this folder

archive_of() {       # the meshes of an installed package, if the image kept its documentation
  installed=/usr/share/doc/libcgal-dev/data.tar.gz
  if [ -s "$installed" ]; then
    echo "$installed"
    return
  fi
  cd "$work"
  apt-get download -qq -o APT::Sandbox::User=root libcgal-demo >"$work/log" 2>&1 ||
    { "$root/scripts/install_dependencies.sh" apt update -qq >"$work/log" 2>&1 &&
      apt-get download -qq -o APT::Sandbox::User=root libcgal-demo >>"$work/log" 2>&1; } ||
    { cat "$work/log" >&2
      fail "libcgal-demo could not be downloaded; check the network and the apt sources"; }
  dpkg-deb -x "$work"/libcgal-demo_*.deb "$work/package" >&2 ||
    fail "the downloaded package libcgal-demo is damaged; run this again"
  echo "$work/package$installed"
}

archive=$(archive_of) || exit 1
[ -s "$archive" ] || fail "libcgal-demo holds no data.tar.gz; this release of it is laid out differently"

mkdir -p "$work/meshes" "$target" || fail "$target cannot be made"
tar -xzf "$archive" -C "$work/meshes" || fail "$archive is damaged or the disk is full"
for mesh in $wanted; do
  found=$(find "$work/meshes" -type f -name "$mesh" | sort | head -n 1)
  [ -n "$found" ] || fail "libcgal-demo holds no $mesh; this release of it is laid out differently"
  # Copy under a temporary name first, so that an interrupted run leaves no partial mesh.
  cp "$found" "$target/.$mesh.part" && mv "$target/.$mesh.part" "$target/$mesh" ||
    fail "$target/$mesh cannot be written"
done
echo "fetch_bodies: $(echo "$wanted" | wc -w) meshes are in $target"
