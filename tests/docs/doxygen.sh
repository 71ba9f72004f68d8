#!/usr/bin/env bash
# doxygen.sh DOXYGEN DOXYFILE: every public type and free function is documented, and in the headers of a plugin's interface every
# member too; no comment is malformed or names what is not there.
set -euo pipefail
doxygen=$1 doxyfile=$2
whole='(coordinate_model|obstacle|registrar|plugin|augmented_lagrangian|error|circle|wall)'
output=$(sed -n 's/^OUTPUT_DIRECTORY *= *"\(.*\)"/\1/p' "$doxyfile")
rm -rf "$output"
mkdir -p "$output"
"$doxygen" "$doxyfile" 2> "$output/warnings" || { cat "$output/warnings"; exit 1; }
[[ -s $output/html/index.html ]]
awk -v whole="/core/include/tendril/$whole\\.hpp:" '
  /warning: Member .* of (class|struct) .* is not documented\./ && $0 !~ whole { others++; next }
  { print; faults++ }
  END { print others + 0 " members in other headers have no comment of their own"; exit faults > 0 }
' "$output/warnings"
