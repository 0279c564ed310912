#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run_ctest.sh BUILD_DIR [CTEST OPTIONS]: runs the tests of a build folder and prints how many ran, passed, failed and
# were skipped. Fails if a test fails or if there are no tests.
set -euo pipefail
build=$1
shift
report=$(mktemp)
trap 'rm -f "$report"' EXIT
rm -rf "$build/test_reports"
status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$(nproc)" --output-junit "$report" "$@" || status=$?

# count NAME FILE: the first attribute of this name, which is that of all tests of the file.
count() { { grep -o "\\b$1=\"[0-9]*\"" "$2" || echo "$1=\"0\""; } | head -n 1 | tr -dc '0-9'; }
tests=$(count tests "$report") failed=$(count failures "$report")
skipped=$(($(count skipped "$report") + $(count disabled "$report")))
# A test of CTest that runs a file of GoogleTests leaves a report and counts as those. A process that ends before its report
# counts as one test that failed.
for file in "$build"/test_reports/*.xml; do
  [ -f "$file" ] || continue
  faults=$(count failures "$file")
  tests=$((tests + $(count tests "$file") - 1)) failed=$((failed + faults - (faults > 0)))
  left_out=$(sed -n 's/.*<testcase name="\([^"]*\)".* result="skipped".* classname="\([^"]*\)".*/\2.\1/p' "$file")
  if [ -n "$left_out" ]; then
    echo "$left_out" | sed 's/^/Skipped: /'
    skipped=$((skipped + $(echo "$left_out" | wc -l)))
  fi
done
echo "$((tests - skipped)) tests ran: $((tests - skipped - failed)) passed, $failed failed, $skipped skipped"
exit "$status"
