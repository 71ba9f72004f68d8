#!/usr/bin/env bash
# doxygen.sh DOXYGEN DOXYFILE: every public type, member, function and constant of the headers is documented; no comment is
# malformed or names what is not there.
set -euo pipefail
doxygen=$1 doxyfile=$2
output=$(sed -n 's/^OUTPUT_DIRECTORY *= *"\(.*\)"/\1/p' "$doxyfile")
rm -rf "$output"
mkdir -p "$output"
"$doxygen" "$doxyfile" 2> "$output/warnings" || { cat "$output/warnings"; exit 1; }
# Members of a namespace are looked at only if the namespace itself is documented: then it has a page.
for page in index namespacetendril namespacetendril_1_1plugins namespacetendril_1_1dimension; do
  [[ -s $output/html/$page.html ]] || { echo "no page $page.html"; exit 1; }
done
if [[ -s $output/warnings ]]; then
  cat "$output/warnings"
  exit 1
fi
