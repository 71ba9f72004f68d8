#!/usr/bin/env bash
# packages.sh CPACK BUILD WORK SCENE SOLVER COMPONENT...: the Debian packages are made; each states what its own files need,
# and the command works with one solver's package beside it.
set -euo pipefail
cpack=$1 build=$2 work=$3 scene=$4 solver=$5
components=("${@:6}")
for tool in dpkg-deb dpkg-shlibdeps; do
  command -v "$tool" > /dev/null || { echo "left out: $tool is not here"; exit 77; }
done
rm -rf "$work"
mkdir -p "$work/root"
"$cpack" --config "$build/CPackConfig.cmake" -B "$work/packages" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
field() { dpkg-deb -f "$work/packages/$1"_*.deb "$2"; }
library() {
  case $1 in
    tendril-solver-ipopt) echo libipopt ;;
    tendril-solver-nlopt) echo libnlopt ;;
    tendril-solver-ceres) echo libcholmod ;;
  esac
}
for component in "${components[@]}"; do
  depends=$(field "$component" Depends)
  grep -q 'libstdc++6' <<< "$depends" || { echo "$component: dependencies were not computed: $depends"; exit 1; }
  if [[ $component != tendril ]]; then
    grep -qF "tendril (= $(field tendril Version))" <<< "$depends" || { echo "$component does not need tendril: $depends"; exit 1; }
  fi
  for other in "${components[@]}"; do
    needs=$(library "$other")
    [[ -n $needs ]] || continue
    found=no
    grep -q "$needs" <<< "$depends" && found=yes
    expected=no
    [[ $other == "$component" ]] && expected=yes
    [[ $found == "$expected" ]] || { echo "$component: needs $needs: $found; expected $expected"; exit 1; }
  done
done
for component in tendril "tendril-solver-$solver"; do dpkg-deb -x "$work/packages/$component"_*.deb "$work/root"; done
command=(env -i "$work/root/usr/bin/tendril")
"${command[@]}" plugins | grep '^solver ' > "$work/solvers"
[[ $(cut -d: -f1 "$work/solvers") == "solver $solver" ]] || { cat "$work/solvers"; exit 1; }
"${command[@]}" plan "$scene" --solver "$solver" --json > "$work/plan.json"
grep -q '"status": "solved"' "$work/plan.json"

# The Python package beside them finds library, plugins and command where the packages put them.
if [[ " ${components[*]} " == *' python3-tendril '* ]]; then
  dpkg-deb -x "$work/packages/python3-tendril"_*.deb "$work/root"
  grep -q 'python3-numpy' <<< "$(field python3-tendril Depends)"
  python=(env -i PATH=/usr/bin:/bin PYTHONPATH="$work/root/usr/lib/python3/dist-packages" /usr/bin/python3 -B)
  "${python[@]}" -c '
import sys, tendril
plan = tendril.load(sys.argv[1]).copy({"solver.plugin": sys.argv[2]}).plan()
assert plan.solved and all("/root/usr/lib/" in p["file"] for p in plan["plugins"]), plan' "$scene" "$solver"
  [[ $("${python[@]}" -m tendril --version) == $("${command[@]}" --version) ]]
fi
