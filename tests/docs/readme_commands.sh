#!/usr/bin/env bash
# readme_commands.sh SOURCE BIN WORK: runs every command of the README that starts with the build's own programs, in its order.
set -euo pipefail
source=$1 bin=$2 work=$3
rm -rf "$work"
mkdir -p "$work"
ln -s "$source/scenes" "$work/scenes"
cd "$work"

count=0
while IFS= read -r line; do
  arguments=${line#build/release/bin/}
  case "$arguments" in
    # Minutes long as they stand in the README.
    'tendril-bench report '*) arguments+=' --quick' ;;
    'tendril-evaluation-benchmark'*) arguments+=' --benchmark_min_time=0.01' ;;
  esac
  echo "run: $arguments"
  start=$SECONDS
  # The shell takes the line apart as it would for a reader, quotes and all.
  eval "\"\$bin\"/$arguments" > log 2>&1 < /dev/null || { cat log; exit 1; }
  echo "     $((SECONDS - start)) s"
  count=$((count + 1))
done < <(sed -n 's/^    \(build\/release\/bin\/.*\)$/\1/p' "$source/README.md")
((count >= 8)) || { echo "only $count commands found in the README"; exit 1; }
