#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# docs.sh: builds the documentation site in build/docs/html, which works offline. It contains the pages of docs/, the
# list of all methods as the program prints it, and the API from the headers. The script installs missing packages.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/install_dependencies.sh docs
program=${SELVEDGE_PROGRAM:-build/release/apps/selvedge}
if [ ! -x "$program" ]; then
  echo "$program is not there; build it first (scripts/test.sh), or name one by SELVEDGE_PROGRAM" >&2
  exit 2
fi

out=build/docs
rm -rf "$out"
mkdir -p "$out/pages/_static/katex"
cp -r docs/*.md docs/images docs/lab "$out/pages"
cp docs/site/conf.py docs/site/index.md "$out/pages"
cp docs/site/formulas.js docs/site/wide.css "$out/pages/_static"
cp -rL /usr/share/javascript/katex/. "$out/pages/_static/katex"
cp README.md "$out/pages/getting_started.md"
cp CHANGELOG.md "$out/pages/changelog.md"
"$program" list --json >"$out/methods.json"
/usr/bin/python3 docs/site/make_pages.py . "$out/pages" "$out/methods.json"
# Every page of docs/ that the index does not name describes methods.
pages=
for page in docs/*.md; do
  name=$(basename "$page" .md)
  grep -qx "$name" docs/site/index.md || pages+="$name\\n"
done
sed -i "s/@METHOD_PAGES@/$pages/" "$out/pages/index.md"

libraries=$(awk -F' [|] ' '$2 ~ /^(detectors|simulation|program)$/ { print $1 }' cmake/rooms.txt)
(cat docs/site/Doxyfile; echo "INPUT = ${libraries//$'\n'/ }"; echo "OUTPUT_DIRECTORY = $out") | scripts/quietly.sh doxygen -
SELVEDGE_DOXYGEN_XML=$PWD/$out/xml scripts/quietly.sh sphinx-build -W --keep-going -q -b html "$out/pages" "$out/html"
echo "Written: $out/html/index.html"
