#!/usr/bin/env bash
# headers.sh PREFIX WORK COMPILER: every installed header compiles alone, with nothing included before it.
set -euo pipefail
prefix=$1 work=$2 compiler=$3
rm -rf "$work"
mkdir -p "$work"
cd "$prefix/include"
find tendril -name '*.hpp' | sort > "$work/headers"
(($(wc -l < "$work/headers") > 30))
for header in $(< "$work/headers"); do
  printf '#include "%s"\n#include "%s"\n' "$header" "$header" > "$work/${header//\//_}.cpp"
done
# Most headers are the same as the last time; where ccache is, it knows.
launcher=()
if command -v ccache > /dev/null; then launcher=(ccache); fi
flags=(-std=c++20 -O0 -c -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -I. -isystem /usr/include/eigen3)
ls "$work"/*.cpp | xargs -P 2 -I '{}' "${launcher[@]}" "$compiler" "${flags[@]}" '{}' -o '{}.o'
