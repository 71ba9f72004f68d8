#!/usr/bin/env bash
# usage.sh CHECK SCENE: what cannot be checked is told on standard error with exit code 2, and nothing counts as right.
set -euo pipefail
check=$1 scene=$2
failed=0
expect() {
  local words=$1 code=0 err
  shift
  err=$("$check" "$@" 2>&1 > /dev/null) || code=$?
  if [[ $code != 2 ]] || ! grep -qF -- "$words" <<< "$err"; then
    echo "'$*': exit code $code, '$err'; expected 2 and '$words'"
    failed=1
  fi
}
expect 'usage:'
expect 'usage:' coordinates
expect '--scene has no value' coordinates psc --scene
expect "found '--color red'" coordinates psc --color red
expect "found the kind 'solver'" solver nlopt
expect 'missing_plugin' coordinates missing_plugin
expect '--set changes a key of a scene' coordinates psc --set a=b
expect "does not use the objective 'grasp_balance'" objective grasp_balance --scene "$scene"
exit "$failed"
