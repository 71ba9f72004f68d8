#!/usr/bin/env bash
# new.sh PREFIX WORK KIND COMPILER SOLVER [bench]: the project that `tendril new KIND` writes is built, listed, tested,
# planned with and benchmarked as it is. SOLVER plans the scenes that name none.
set -euo pipefail
prefix=$1 work=$2 kind=$3 compiler=$4 solver=$5 bench=${6:-}
rm -rf "$work"
mkdir -p "$work"
cd "$work"
clean() { env -i PATH="$prefix/bin:/usr/bin:/bin" HOME="$work" "$@"; }
quiet() { "$@" > log 2>&1 || { cat log; exit 1; }; }
name=my_first_$kind
[[ $kind == solver ]] && solver=$name

clean tendril new "$kind" "$name" > told
grep -q "cmake -S $name" told
lines=$(wc -l < "$name/$name.cpp")
((lines < 50)) || { echo "$name.cpp has $lines lines; expected fewer than 50"; exit 1; }
quiet clean cmake -S "$name" -B "$name/build" -G Ninja -DCMAKE_CXX_COMPILER="$compiler" -DTENDRIL_TEST_SOLVER="$solver" \
  -DCMAKE_CXX_FLAGS='-O1 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror'
quiet clean cmake --build "$name/build"
quiet clean ctest --test-dir "$name/build" --output-on-failure
grep -q '100% tests passed, 0 tests failed out of 2' log
# Through a file: grep -q leaves as soon as it has found the line, and the writer of a pipe would die of that.
clean tendril plugins --plugin-dir "$name/build" > listed
grep -q "^$kind $name: " listed
clean tendril plan "$name/scene.toml" --plugin-dir "$name/build" --solver "$solver" --json > plan.json
grep -q '"status": "solved"' plan.json
grep -q "\"$name" plan.json || grep -q "\"name\": \"$name\"" plan.json || [[ $kind == obstacle ]]
if [[ -n $bench ]]; then
  clean tendril-bench solvers "$name/scene.toml" --plugin-dir "$name/build" --solver "$solver" > table
  grep -E "\| $solver +\| 1 +\| 1 " table || { cat table; exit 1; }
fi
