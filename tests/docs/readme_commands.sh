#!/usr/bin/env bash
# readme_commands.sh SOURCE BIN WORK PAGE...: runs every command of the pages that starts with the build's own programs, in their
# order: a line of its own, or a cell of a table. What stands twice is run once.
set -euo pipefail
source=$1 bin=$2 work=$3
shift 3
rm -rf "$work"
mkdir -p "$work"
ln -s "$source/scenes" "$work/scenes"
cd "$work"

count=0
while IFS= read -r arguments; do
  case "$arguments" in
    # Minutes long as they stand in the README. All of the extreme cases have a test of their own.
    'tendril-bench report '*) arguments+=' --quick --only "torque limit"' ;;
    'tendril-evaluation-benchmark'*) arguments+=' --benchmark_min_time=0.01' ;;
  esac
  echo "run: $arguments"
  start=$SECONDS
  # The shell takes the line apart as it would for a reader, quotes and all.
  eval "\"\$bin\"/$arguments" > log 2>&1 < /dev/null || { cat log; exit 1; }
  echo "     $((SECONDS - start)) s"
  count=$((count + 1))
done < <(cd "$source" && sed -nE 's/^    (build\/release\/bin\/.*)$/\1/p; s/^\|.*\| `(tendril[^`]*)` \|.*$/\1/p' "$@" | sed 's/^build\/release\/bin\///' |
  awk '!seen[$0]++')
((count >= 15)) || { echo "only $count commands found"; exit 1; }
