#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# platforms.sh [--folder FOLDER] [--quick] [NAME...]: tries the sources of the last commit in empty systems, each made by
# debootstrap, and prints a row of a table for each. Needs root, debootstrap and the network; the first use of a system
# downloads it. FOLDER (/var/tmp/selvedge_platforms) takes 3 GB a system; one of an earlier run compiles what has changed.
#   debian12-gcc debian13-gcc sid-gcc        g++ of the system: build, all tests, hashes of six scenes
#   debian12-clang debian13-clang sid-clang  its newest clang: build, tests without the label `slow`, hashes
#   windows                                  apps/windows/build.sh, and check.sh under Wine against build/release/apps/selvedge of
#                                            the same commit; on this system, not in an empty one
#   deb wheel                                the packages of scripts/release.sh in build/packages, in an empty Debian 12 (the
#                                            wheel: with NumPy): seconds to install them and to the first clean drape
#   deb-library                              the .deb files of the library and of the Python module: examples/find_collisions.cpp
#                                            against the one, the first lines of docs/python.md with the other
#   pip                                      what docs/python.md says about `pip install .`, from the sources, in Debian 12
# --quick leaves out the tests with the label `slow` for g++ as well. Without names: the first three.
# Hashes are compared with those of build/release/apps/selvedge, where it exists, else with those of the first row.
# Ends with 1 if a build, a test or a hash fails.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folder=/var/tmp/selvedge_platforms
quick=
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --folder) folder=$2; shift ;;
    --quick) quick=--label-exclude=slow ;;
    debian12-gcc | debian13-gcc | sid-gcc | debian12-clang | debian13-clang | sid-clang | windows | deb | deb-library | wheel | pip) names+=("$1") ;;
    *) sed -n '3,19s/^# //p' "${BASH_SOURCE[0]}" >&2; exit 2 ;;
  esac
  shift
done
[ ${#names[@]} -gt 0 ] || names=(debian12-gcc debian13-gcc sid-gcc)
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "platforms.sh needs root and debootstrap (apt install debootstrap)" >&2
  exit 2
fi
mkdir -p "$folder"
folder=$(realpath "$folder")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
scenes=(cloth_on_sphere flag hysteresis incline plate_2 finite_elements)
failed=no

# inside SYSTEM COMMAND: runs it in the system, which sees no variables and no files of this one but /proc and /dev.
inside() {
  unshare -m bash -c '
    mount --make-rprivate / && mount --bind /proc "$0/proc" && mount --bind /dev "$0/dev" &&
    exec chroot "$0" env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive PATH=/usr/sbin:/usr/bin:/sbin:/bin bash -ec "cd /root; $1"
  ' "$folder/$1" "$2"
}

# An empty system: empty_system bookworm.
empty_system() {
  if [ ! -e "$folder/$1/complete" ]; then
    rm -rf "${folder:?}/$1"
    debootstrap --variant=minbase "$1" "$folder/$1" ${MIRROR:+"$MIRROR"} >"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; exit 1; }
    touch "$folder/$1/complete"
  fi
}

# copy_of bookworm NAME: a system of that name, from the empty one unless there is one.
copy_of() {
  empty_system "$1"
  [ -e "$folder/$2/complete" ] || { rm -rf "${folder:?}/$2"; cp -a "$folder/$1" "$folder/$2"; }
  cp /etc/resolv.conf "$folder/$2/etc/resolv.conf"
}

# Copies the committed sources. A file that has not changed keeps its time.
copy_sources() {
  rm -rf "$work/sources"
  mkdir -p "$work/sources"
  git -C "$root" archive HEAD | tar -x -C "$work/sources"
  (cd "$work/sources" && find . -type f) | while read -r file; do
    cmp -s "$work/sources/$file" "$folder/$1/root/selvedge/$file" || install -D -p "$work/sources/$file" "$folder/$1/root/selvedge/$file"
  done
}

# Compares the hashes of a file with the first ones.
compare_hashes() {
  local differing
  [ -s "$work/hashes" ] || cp "$1" "$work/hashes"
  differing=$(diff "$work/hashes" "$1" | sed -n 's/^> *\([^ ]*\).*/\1/p' | xargs)
  echo "${differing:-$(wc -l <"$1") equal}"
}

build_and_test() {
  local name=$1 suite=bookworm seconds=$SECONDS tests=$quick cxx=g++ c=gcc built=yes passed same versions
  case $name in debian13*) suite=trixie ;; sid*) suite=sid ;; esac
  copy_of "$suite" "$name"
  copy_sources "$name"
  inside "$name" '
    apt-get update -q
    wanted=
    for package in $(selvedge/scripts/install_dependencies.sh names platform) ccache; do
      if apt-cache show "$package" >/dev/null 2>&1; then wanted+=" $package"; else echo "missing here: $package"; fi
    done
    apt-get install -qy --no-install-recommends $wanted' >"$work/$name.packages" 2>&1 || { tail -n 20 "$work/$name.packages" >&2; exit 1; }
  if [[ $name == *clang ]]; then
    tests=--label-exclude=slow
    # The packages end with their version.
    inside "$name" 'apt-cache pkgnames clang- | grep -xE "clang-[0-9]+" | sort -V | tail -n 1 >clang; apt-get install -qy --no-install-recommends "$(cat clang)"' >"$work/log" 2>&1
    cxx=clang++-$(cut -d- -f2 "$folder/$name/root/clang") c=$(cat "$folder/$name/root/clang")
  fi
  inside "$name" "cd selvedge; cmake --preset release -G Ninja -DSELVEDGE_UNITY=ON -DCMAKE_CXX_COMPILER=$cxx -DCMAKE_C_COMPILER=$c &&
    ninja -C build/release -k 0" >"$work/$name.build" 2>&1 || { built=no; failed=yes; grep -m 5 'error' "$work/$name.build" >&2 || true; }
  versions=$(inside "$name" "$cxx -dumpfullversion 2>/dev/null || $cxx -dumpversion")
  if [ "$built" = yes ]; then
    inside "$name" "cd selvedge; ctest --test-dir build/release -j 2 $tests" >"$work/$name.tests" 2>&1 || failed=yes
    passed=$(sed -n 's/.*tests passed, \([0-9]*\) tests failed out of \([0-9]*\)/\2, of which \1 fail/p' "$work/$name.tests")
    grep -E '\(Failed\)|\(Timeout\)|\(SEGFAULT\)|Not Run' "$work/$name.tests" | sed "s/^/$name: /" >&2 || true
    inside "$name" "cd selvedge/data/scenes; ../../scripts/scene_hashes.sh --frames 6 ${scenes[*]/%/.json}" >"$work/$name.hashes"
    same=$(compare_hashes "$work/$name.hashes")
    [[ $same == *equal ]] || failed=yes
  fi
  echo "| $name | ${cxx%%-*} $versions | $(libraries "$name") | $built | ${passed:--} | ${same:--} | $((SECONDS - seconds)) |"
}

build_for_windows() {
  local seconds=$SECONDS here=$folder/windows/root/selvedge built=yes same=-
  "$root/scripts/install_dependencies.sh" windows
  copy_sources windows
  (cd "$here" && apps/windows/build.sh build/windows) >"$work/windows.build" 2>&1 || { built=no; failed=yes; tail -n 20 "$work/windows.build" >&2; }
  if [ "$built" = yes ]; then
    "$here/apps/windows/check.sh" "$here"/build/windows/selvedge-*-windows.zip "$root/build/release/apps/selvedge" >"$work/windows.check" 2>&1 || failed=yes
    grep ': NO$' "$work/windows.check" | sed 's/^/windows: /' >&2 || true
    same=$(sed -n 's/^hashes of six scenes as native: //p' "$work/windows.check")
  fi
  echo "| windows | MinGW-w64 g++ $(x86_64-w64-mingw32-g++-posix -dumpversion) | | $built | check.sh: $(grep -c ': yes$' "$work/windows.check" || true) pass | equal: $same | $((SECONDS - seconds)) |"
}

# The optional libraries of the build in a system, with their versions.
libraries() {
  inside "$1" 'selvedge/build/release/apps/selvedge --version 2>/dev/null' | sed -n 's/^ *\(assimp\|embree\|CGAL\|fcl\) \([^ ]*\).*/\1 \2/p' | xargs | sed 's/ \([a-z]\)/, \1/g' || true
}

# Processor time of the commands that have ended, s.
processor() { awk '{ printf "%d\n", ($16 + $17) / 100 }' /proc/$$/stat; }

# first_drape SUITE NAME PREPARE INSTALL DRAPE: an empty system, after PREPARE.
first_drape() {
  local suite=$1 name=$2 installed seconds used
  copy_of "$suite" "$name"
  inside "$name" "$3" >"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; exit 1; }
  seconds=$(date +%s) used=$(processor)
  inside "$name" "$4" >"$work/log" 2>&1 || { tail -n 20 "$work/log" >&2; failed=yes; }
  installed=$(($(date +%s) - seconds))
  inside "$name" "$5" >"$work/$name.drape" 2>&1 && grep -qE '^clean( |$)' "$work/$name.drape" || { tail -n 5 "$work/$name.drape" >&2; failed=yes; }
  echo "| $name | $suite | installed after $installed s, draped after $(($(date +%s) - seconds)) s, processor $(($(processor) - used)) s | $(grep -m 1 -E '^clean' "$work/$name.drape" || echo failed) |"
  rm -rf "${folder:?}/$name"
}
first_lines() { awk '/^```python/ { on = 1; next } /^```/ && on { exit } on' "$root/docs/python.md"; }

if [[ " ${names[*]} " =~ -(gcc|clang)" " ]] && [ -x "$root/build/release/apps/selvedge" ]; then
  (cd "$root/data/scenes" && "$root/scripts/scene_hashes.sh" --frames 6 "${scenes[@]/%/.json}") >"$work/hashes"
fi
for name in "${names[@]}"; do
  case $name in
    windows) build_for_windows ;;
    deb)
      empty_system bookworm
      copy_of bookworm deb
      cp "$root"/build/packages/selvedge_*debian12*.deb "$folder/deb/root/"
      # shellcheck disable=SC2016
      first_drape bookworm deb true 'apt-get update -q; apt-get install -qy ./selvedge_*.deb' \
        'selvedge run /usr/share/selvedge/scenes/cloth_on_sphere.json --out drape && selvedge check drape'
      ;;
    deb-library)
      copy_of bookworm deb-library
      cp "$root"/build/packages/{libselvedge-dev,python3-selvedge}_*debian12*.deb "$root/examples/find_collisions.cpp" "$folder/deb-library/root/"
      first_lines >"$folder/deb-library/root/first_drape.py"
      cat >"$folder/deb-library/root/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES CXX)
find_package(selvedge REQUIRED COMPONENTS detection)
add_executable(find_collisions find_collisions.cpp)
target_link_libraries(find_collisions PRIVATE selvedge::detection)
END
      # shellcheck disable=SC2016
      first_drape bookworm deb-library 'apt-get update -q; apt-get install -qy --no-install-recommends g++ cmake make' \
        'apt-get install -qy --no-install-recommends ./*.deb' \
        'cmake -S . -B build; cmake --build build; build/find_collisions; python3 first_drape.py'
      ;;
    wheel)
      copy_of bookworm wheel
      cp "$root"/build/packages/selvedge-*-cp311-*.whl "$folder/wheel/root/"
      first_lines >"$folder/wheel/root/first_drape.py"
      first_drape bookworm wheel \
        'apt-get update -q; apt-get install -qy --no-install-recommends python3-numpy python3-venv; python3 -m venv --system-site-packages venv' \
        'venv/bin/pip install ./selvedge-*.whl' 'venv/bin/python first_drape.py'
      ;;
    pip)
      copy_of bookworm pip
      copy_sources pip
      first_lines >"$folder/pip/root/first_drape.py"
      first_drape bookworm pip 'selvedge/scripts/install_dependencies.sh python' \
        'python3 -m venv --system-site-packages venv; venv/bin/pip install ./selvedge' 'venv/bin/python first_drape.py'
      ;;
    *) build_and_test "$name" ;;
  esac
done
[ "$failed" = no ]
