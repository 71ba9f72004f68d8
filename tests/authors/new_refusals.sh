#!/usr/bin/env bash
# new_refusals.sh PREFIX WORK: names and places that cannot be are refused with one message, and nothing is written.
set -euo pipefail
prefix=$1 work=$2
rm -rf "$work"
mkdir -p "$work/taken" "$work/empty"
touch "$work/file"
ln -s nowhere "$work/link"
cd "$work"

refused() {
  local expected=$1 code=0 before after
  shift
  before=$(find . | sort)
  "$prefix/bin/tendril" new "$@" > out 2> err || code=$?
  after=$(find . ! -name out ! -name err | sort)
  [[ $code == 2 ]] || { echo "new $*: exit code $code; expected 2"; exit 1; }
  [[ $(wc -l < err) == 1 && ! -s out ]] || { echo "new $*: expected one line of error"; cat out err; exit 1; }
  grep -qF -- "$expected" err || { echo "new $*: expected '$expected'"; cat err; exit 1; }
  [[ $(grep -vE '^\./(out|err)$' <<< "$before") == "$after" ]] || { echo "new $*: left files behind"; exit 1; }
}
refused "did you mean 'solver'" solvr mine
refused "expected coordinates, objective" plugin mine
for bad in Mine 9lives my-term 'my term' ../up _x '' "$(printf 'a%.0s' {1..65})" $'new\nline' 'ä'; do
  refused 'expected lower-case letters' objective "$bad"
done
refused 'is taken' objective tip_pose
refused 'is taken' obstacle circle
refused 'exists already' objective taken
refused 'exists already' objective file
refused 'exists already' objective link
refused 'exists already' objective mine empty
refused 'exists already' objective mine .
refused 'empty directory name' objective mine ''
refused 'cannot write into' objective mine file/below
refused 'NAME' objective
