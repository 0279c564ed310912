# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# mutants_lib.sh: what mutants.sh and mutants_margins.sh share. A mutant is the library with one change that a test must
# notice. To compile every source once, all changes go into one copy of the sources, each behind a switch: the
# environment variable SELVEDGE_MUTANT holds the number of the change that is made; without it nothing is changed.
#
#   CXX, FLAGS      compiler and flags that the sources of the library need
#   SOURCE          root of the sources
#   INCLUDE         folder that holds selvedge/, a link to the sources
#   WORK            folder for the results, made anew
#   JOBS            processes at a time (default: processors)
JOBS=${JOBS:-$(nproc)}
rm -rf "$WORK"
mkdir -p "$WORK/changed"

declare -A text       # of every changed file, with the changes so far
names=()              # of the changes; the number of a change is its place, from 1 on

# change NAME FILE FROM TO: where FROM occurs first in FILE, TO is an alternative. FROM is a whole expression, or
# statements that end in a semicolon, as TO is; where it is only a part of the text, @ stands at both ends of that part.
change() {
  local name=$1 file=$2 from=$3 to=$4 before="" after="" both number
  [ -n "${text[$file]:-}" ] || text[$file]=$(cat "$SOURCE/$file")
  if [[ $from == *@*@* ]]; then
    before=${from%%@*} after=${from##*@} from=${from#*@}
    from=${from%@*}
  fi
  if [[ ${text[$file]} != *"$before$from$after"* ]]; then
    echo "$name: \"$before$from$after\" is not in $file any more"
    exit 1
  fi
  names+=("$name")
  number=${#names[@]}
  # The first alternative is the unchanged text, in which further changes may find their place.
  if [[ $from == *\; ]]; then
    both="{ if (selvedge_mutant != $number) { $from } else { $to } }"
  else
    both="(selvedge_mutant != $number ? ($from) : ($to))"
  fi
  text[$file]=${text[$file]/"$before$from$after"/"$before$both$after"}
}

# number NAME: of the change.
number() {
  local i
  for i in "${!names[@]}"; do
    [ "${names[$i]}" != "$1" ] || { echo $((i + 1)); return; }
  done
  echo "$1: no such change" >&2
  return 1
}

# write_changes: the changed files, in changed/selvedge.
write_changes() {
  local file
  for file in "${!text[@]}"; do
    mkdir -p "$WORK/changed/selvedge/$(dirname "$file")"
    # A constant with an alternative is known only when the program runs.
    printf '%s\n' "${text[$file]}" | sed '/selvedge_mutant/s/\<constexpr\>/const/' >"$WORK/changed/selvedge/$file"
  done
}

# source_of FILE: the changed file, if write_changes has written one.
source_of() {
  if [ -f "$WORK/changed/selvedge/$1" ]; then echo "$WORK/changed/selvedge/$1"; else echo "$SOURCE/$1"; fi
}

# precompile HEADERS OPTIONS: HEADERS.gch. Most of the compile time of a source goes to headers. The switch is in HEADERS.
precompile() {
  { cat <<'END'
#include <cstdlib>
inline const int selvedge_mutant = [] {
  const char* number = std::getenv("SELVEDGE_MUTANT");
  return number == nullptr ? 0 : std::atoi(number);
}();
END
    cat "$1"
  } >"$1.new" && mv "$1.new" "$1"
  # shellcheck disable=SC2086
  compile $2 -x c++-header "$1" -o "$1.gch"
}

# compile OPTIONS... SOURCE -o OBJECT: as the library is compiled.
compile() {
  # shellcheck disable=SC2086
  "$CXX" -std=c++20 -DNDEBUG -ffp-contract=off $FLAGS -I"$WORK/changed" -I"$INCLUDE" "$@"
}

# link PROGRAM FILES...: a program. The library's objects hold several sources each. Of two definitions the linker takes
# the first, and position-independent code calls it everywhere.
link() {
  local program=$1
  shift
  # shellcheck disable=SC2086
  "$CXX" $FLAGS "$@" -Wl,-z,muldefs -Wl,--start-group $LIBRARIES -Wl,--end-group -o "$program"
}

# link_again PROGRAM OBJECTS...: a test program of the build folder BUILD of Ninja, in $WORK, with these objects of
# changed sources, which come first (see link).
link_again() {
  local program=$1 command
  shift
  command=$(ninja -C "$BUILD" -t commands "tests/$program" | grep -F -- " -o tests/$program " | sed 's/^: && //; s/ && .*//')
  command=${command/ -o tests\/$program / $* -Wl,-z,muldefs -o $WORK/$program }
  (cd "$BUILD" && eval "$command")
}

running=0
failed=0
finish() {
  wait -n || failed=1
  running=$((running - 1))
}
# try COMMAND...: runs it beside others.
try() {
  [ "$running" -lt "$JOBS" ] || finish
  "$@" &
  running=$((running + 1))
}
# tried: waits for all of them; 0 if none has failed.
tried() {
  while [ "$running" -gt 0 ]; do finish; done
  return "$failed"
}
# compile_changes: the changed sources with -O1, as objects in $WORK. Their headers are compiled once, because they take two
# thirds of the time of a source; those with a capital name depend on what is defined before them.
compile_changes() {
  local headers=$WORK/headers.h file
  for file in "${!text[@]}"; do grep '^#include <[a-z]' "$SOURCE/$file"; done | sort -u >"$headers"
  write_changes
  precompile "$headers" -O1 || exit 1
  for file in "${!text[@]}"; do
    try compile -O1 -include "$headers" -c "$(source_of "$file")" -o "$WORK/${file//\//_}.o"
  done
  tried || { echo "The changed sources do not compile"; exit 1; }
}
