#!/usr/bin/env bash
# flaws.sh CHECK PLUGINS SCENE KIND KEY FLAW=MISTAKE...: the check finds nothing wrong without a flaw, and each flaw by name.
set -euo pipefail
check=$1 plugins=$2 scene=$3 kind=$4 key=$5
run() { "$check" "$kind" flawed --plugin-dir "$plugins" --scene "$scene" --set "$key=\"$1\""; }
out=$(run none) || { echo "$out"; exit 1; }
failed=0
for pair in "${@:6}"; do
  code=0
  out=$(run "${pair%%=*}") || code=$?
  echo "--- ${pair%%=*}: exit code $code"
  echo "$out"
  if [[ $code != 1 ]] || ! grep -qF "  ${pair#*=}: " <<< "$out"; then
    echo "expected exit code 1 and '${pair#*=}'"
    failed=1
  fi
done
exit "$failed"
