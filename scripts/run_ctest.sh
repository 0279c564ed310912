#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run_ctest.sh BUILD_DIR [CTEST OPTIONS]: runs the tests of a build folder and prints how many ran, passed, failed and
# were skipped. Fails if a test fails or if there are no tests.
set -euo pipefail
build=$1
shift
report=$(mktemp)
trap 'rm -f "$report"' EXIT
status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$(nproc)" --output-junit "$report" "$@" || status=$?

# Counts from the single <testsuite> element that CTest writes.
count() { { grep -o "\\b$1=\"[0-9]*\"" "$report" || echo "$1=\"0\""; } | head -n 1 | tr -dc '0-9'; }
tests=$(count tests) failed=$(count failures) skipped=$(( $(count skipped) + $(count disabled) ))
echo "$((tests - skipped)) tests ran: $((tests - skipped - failed)) passed, $failed failed, $skipped skipped"
exit "$status"
