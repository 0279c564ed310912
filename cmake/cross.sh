# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Functions for scripts that build for another system with what Debian has for this one.

# debian_source OUT NAME: fetches the source package NAME and unpacks what Debian calls the original to OUT/NAME_source, unless it is
# there.
debian_source() {
  local out=$1 name=$2 list=/etc/apt/sources.list.d/debian.sources
  [ ! -e "$out/${name}_source/complete" ] || return 0
  # The lists of sources, which few systems have.
  mkdir -p "$out/apt/lists/partial" "$out/${name}_source"
  if [ -f "$list" ]; then sed 's/^Types:.*/Types: deb-src/' "$list" >"$out/apt/source.sources"; fi
  if [ -s /etc/apt/sources.list ]; then sed -n 's/^deb /deb-src /p' /etc/apt/sources.list >"$out/apt/source.list"; fi
  local apt=(apt-get -q -oDir::Etc::SourceList=/dev/null -oDir::Etc::SourceParts="$out/apt" -oDir::State::Lists="$out/apt/lists"
    -oDir::Cache::srcpkgcache= -oDir::Cache::pkgcache=)
  (cd "$out" && "${apt[@]}" update && "${apt[@]}" source --tar-only "$name") >"$out/$name.log" 2>&1 || { tail -n 20 "$out/$name.log" >&2; return 1; }
  tar -xf "$out/${name}"_*.orig.tar.* -C "$out/${name}_source" --strip-components=1
  touch "$out/${name}_source/complete"
}

# version_of PACKAGE FOLDER: the version that its headers state.
version_of() {
  case $1 in
    CLI11) sed -n 's/^#define CLI11_VERSION "\(.*\)"/\1/p' "$2/CLI/Version.hpp" ;;
    fmt) awk '/^#define FMT_VERSION/ { printf "%d.%d.%d\n", $3 / 10000, $3 / 100 % 100, $3 % 100 }' "$2/fmt/core.h" ;;
    nlohmann_json) sed -n 's/^#define NLOHMANN_JSON_VERSION_[A-Z]* \([0-9]*\).*/\1/p' "$2/nlohmann/detail/abi_macros.hpp" | paste -sd. ;;
  esac
}

# header_packages OUT: copies the headers of Eigen, JSON, fmt and CLI11 to OUT/include, because /usr/include must not be searched, and
# makes OUT/packages, where CMake finds them.
header_packages() {
  local out=$1 package name
  if [ ! -d "$out/include/CLI" ]; then
    mkdir -p "$out/include"
    cp -r "${EIGEN_INCLUDE:-/usr/include/eigen3}/Eigen" "${JSON_INCLUDE:-/usr/include}/nlohmann" "${FMT_INCLUDE:-/usr/include}/fmt" \
      "${CLI11_INCLUDE:-/usr/include}/CLI" "$out/include/"
  fi
  for package in nlohmann_json::nlohmann_json fmt::fmt CLI11::CLI11; do
    name=${package%::*}
    mkdir -p "$out/packages/$name"
    echo "if(NOT TARGET $package)
  add_library($package INTERFACE IMPORTED)
endif()" >"$out/packages/$name/${name,,}-config.cmake"
    echo "set(PACKAGE_VERSION $(version_of "$name" "$out/include"))
set(PACKAGE_VERSION_COMPATIBLE TRUE)" >"$out/packages/$name/${name,,}-config-version.cmake"
  done
}
