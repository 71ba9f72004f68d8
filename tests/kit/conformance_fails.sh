#!/usr/bin/env bash
# conformance_fails.sh CONFORMANCE PLUGINS: a solver that claims success where it began is caught, in words.
set -euo pipefail
code=0
out=$("$1" --plugin-dir "$2" --solver lazy --gtest_filter='EverySolver/*' --gtest_brief=1 2>&1) || code=$?
echo "$out"
[[ $code == 1 ]]
grep -q 'lazy on hs071' <<< "$out"
