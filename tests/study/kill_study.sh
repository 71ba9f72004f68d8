#!/usr/bin/env bash
# Kills a study at random moments and runs it again until it is finished; the files must then be the same, byte for
# byte, as those of a study that nobody disturbed, and no case may have been computed twice.
#   kill_study.sh TENDRIL SCENE [ROUNDS [SEED]]
set -euo pipefail
tendril=$1 scene=$2 rounds=${3:-20} seed=${4:-1}
RANDOM=$seed
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
files=(study.json cases.csv groups.csv table.txt figure.dat figure.gnuplot figure.svg)

begin=$(date +%s%N)
"$tendril" study "$scene" --jobs 2 --output "$work/whole" > "$work/whole.txt"
whole=$((($(date +%s%N) - begin) / 1000000))

total=0
for ((round = 1; round <= rounds; ++round)); do
  kills=0
  while true; do
    "$tendril" study "$scene" --jobs 2 --output "$work/$round" > "$work/$round.txt" 2> "$work/err" &
    child=$!
    # Any moment of an undisturbed study, at most five times; then it may finish.
    ((kills >= 5)) && break
    moment=$((RANDOM % (whole + 1)))
    sleep "$(printf '%d.%03d' $((moment / 1000)) $((moment % 1000)))"
    signal=KILL
    ((RANDOM % 3 == 0)) && signal=INT
    if ! kill -s "$signal" "$child" 2> "$work/kill"; then break; fi
    status=0
    wait "$child" 2> "$work/wait" || status=$?
    ((status == 0)) && break
    ((++kills, ++total))
  done
  wait "$child" || { echo "round $round: the study failed"; cat "$work/err"; exit 1; }
  for file in "${files[@]}"; do
    cmp "$work/whole/$file" "$work/$round/$file" || { echo "round $round, after $kills kills: $file differs"; exit 1; }
  done
  cmp "$work/whole.txt" "$work/$round.txt"
  doubles=$(tail -n +2 "$work/$round/shard-1-of-1.journal" | cut -d' ' -f1 | sort | uniq -d)
  if [[ -n $doubles ]]; then echo "round $round: cases computed twice: $doubles"; exit 1; fi
  rm -r "${work:?}/$round"
done
echo "$rounds studies, killed $total times, all the same"
