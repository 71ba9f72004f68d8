#!/usr/bin/env bash
# conformance_flaws.sh CONFORMANCE PLUGINS FLAW=TEST...: the suite passes a solver without a flaw, and fails each flaw by each of its
# tests (Suite.Name, several flaws may share one). Tests of core's own promises, which no backend can break, are not among them.
set -euo pipefail
conformance=$1 plugins=$2
run() {
  TENDRIL_FLAW=$1 "$conformance" --plugin-dir "$plugins" --solver flawed --gtest_filter="EverySolver/$2" --gtest_brief=1 2>&1
}
# Without a library it is not strong enough for one of the programs with complementarity.
out=$(run none '*-*outrata31_penalty') || { echo "$out"; echo "a solver without a flaw fails"; exit 1; }
failed=0
for pair in "${@:3}"; do
  flaw=${pair%%=*} test=${pair#*=} code=0
  out=$(run "$flaw" "$test/*") || code=$?
  if [[ $code != 1 ]] || ! grep -qF "[  FAILED  ] EverySolver/$test/flawed" <<< "$out"; then
    echo "--- $flaw: exit code $code, expected 1 and a failure of $test"
    echo "$out"
    failed=1
  fi
done
exit "$failed"
