#!/usr/bin/env bash
# names.sh CHECK PLUGINS SCENE: a term that crashes or never returns ends the check, which names the plugin.
set -euo pipefail
check=$1 plugins=$2 scene=$3
# A sanitizer would report crashes itself.
export ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}handle_segv=0:handle_sigbus=0
failed=0
for pair in crash=crashed overflow=crashed abort=crashed 'endless=did not return in time'; do
  code=0
  said=$("$check" objective flawed --plugin-dir "$plugins" --scene "$scene" --time-limit 2 \
         --set "objective.0.flaw=\"${pair%%=*}\"" 2>&1) || code=$?
  if [[ $code == 0 ]] || ! grep -q "objective plugin 'flawed' .*${pair#*=}" <<< "$said"; then
    echo "${pair%%=*}: exit code $code, '$said'; expected the plugin's name and '${pair#*=}'"
    failed=1
  fi
done
exit "$failed"
