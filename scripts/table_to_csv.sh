#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# table_to_csv.sh < PAGE.md > TABLE.csv: prints every Markdown table row of the standard input as a CSV row. Drops other
# lines and the rules below table heads. Quotes cells that contain a comma or a quotation mark.
set -euo pipefail
awk '
  !/^\|/ || /^\|[-: |]+\|$/ { next }
  {
    sub(/^\| */, "")
    sub(/ *\| *$/, "")
    cells = split($0, cell, / *\| */)
    row = ""
    for (i = 1; i <= cells; ++i) {
      if (cell[i] ~ /[",]/) {
        gsub(/"/, "\"\"", cell[i])
        cell[i] = "\"" cell[i] "\""
      }
      row = row (i > 1 ? "," : "") cell[i]
    }
    print row
  }'
