#!/usr/bin/env bash
# examples.sh PREFIX WORK EXAMPLES COMPILER SOLVER COMBINATION [bench]: all examples are built against the installation,
# tested with its kits, benchmarked, and go through the combination suite.
set -euo pipefail
prefix=$1 work=$2 examples=$3 compiler=$4 solver=$5 combination=$6 bench=${7:-}
rm -rf "$work"
mkdir -p "$work"
cp -r "$examples" "$work/examples"
cd "$work"
# Where ccache is, it knows what has not changed since the last time.
launcher=() cache=${CCACHE_DIR:-${HOME:-$work}/.cache/ccache}
if command -v ccache > /dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
clean() { env -i PATH="$prefix/bin:/usr/bin:/bin" HOME="$work" CCACHE_DIR="$cache" "$@"; }
quiet() { "$@" > log 2>&1 || { cat log; exit 1; }; }

quiet clean cmake -S examples -B build -G Ninja -DCMAKE_CXX_COMPILER="$compiler" -DTENDRIL_TEST_SOLVER="$solver" "${launcher[@]}" \
  -DCMAKE_CXX_FLAGS='-O0 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror'
if grep 'left out' log; then echo 'the rest is tested'; fi
quiet clean cmake --build build --parallel 2
quiet clean ctest --test-dir build --output-on-failure
grep 'tests passed' log

for source in examples/*/scene.toml; do
  name=$(basename "$(dirname "$source")")
  [[ -d build/$name ]] || continue
  kind=$(sed -n 's/^tendril_add_plugin(KIND \([a-z]*\) .*/\1/p' "examples/$name/CMakeLists.txt")
  with=$solver solvers=()
  case $kind in
    coordinates | objective) filter="*_${name}_*:*_${name}" ;;
    # Beside one that is known, whose plans it must find too, in the small scenes.
    solver) with=$name solvers=(--solver "$solver" --solver "$name") filter='Models/*-*_arm_*' ;;
    # Scenes choose their obstacles, so the suite has none to combine: plan and benchmark are what a shape goes through.
    obstacle) filter= ;;
  esac
  if [[ -n $bench ]]; then
    # Plan and tests name the directory as an option, the benchmark by the environment: both ways find a plugin.
    clean TENDRIL_PLUGIN_PATH="$work/build/$name" tendril-bench solvers "$source" --solver "$with" > table
    grep -qE "\| $with +\| 1 +\| 1 " table || { cat table; exit 1; }
  fi
  [[ -n $filter ]] || continue
  "$combination" --plugin-dir "build/$name" "${solvers[@]}" --gtest_list_tests --gtest_filter="$filter" > by_option
  TENDRIL_PLUGIN_PATH="$work/build/$name" "$combination" "${solvers[@]}" --gtest_list_tests --gtest_filter="$filter" > by_environment
  diff by_option by_environment
  quiet "$combination" --plugin-dir "build/$name" "${solvers[@]}" --gtest_filter="$filter" --gtest_brief=1
  echo "$name: $(grep -E 'PASSED' log | tr -s ' ')"
  grep -qE 'PASSED  \] [1-9][0-9]+ tests' log
done

clean build/library/plan_once "$solver" | tee once
# The figures that the README states for the same scene.
grep -qE '^solved, moment .* N mm, tip misses by 0\.42[0-9]* mm$' once
grep -qE '^peg: 78\.[78][0-9]* mN$' once
clean build/library/follow "$solver" | tee follow
grep -qE '^50 of 50 steps solved' follow
# A scene file, read and planned by a program as by the command.
scene=$prefix/share/doc/tendril/scenes/brace.toml
clean build/library/plan_file "$scene" "$solver" | tee file
grep -qE '^solved, tip at 20\.136 mm; under 2\.5 N mm at 22\.002 mm$' file
clean tendril plan "$scene" --set 'contact.max_force=2 N' --solver "$solver" --verify --json > command.json
# Times differ, and each names the plugins' directory as it found it.
without_times() { sed -E '/"(seconds[a-z_]*|assemble|certify|open|read|solve|file|maxtime)":/d' "$1"; }
diff <(without_times plan.json) <(without_times command.json)
printf 'rod = 1\n' > wrong.toml
code=0
clean build/library/plan_file wrong.toml 2> err || code=$?
[[ $code == 2 ]] && grep -q '^wrong.toml:1:7: ' err
code=0
clean build/library/plan_once nosuch 2> err || code=$?
[[ $code == 2 ]] && grep -q "'nosuch'" err
