#!/usr/bin/env bash
# without.sh PREFIX WORK: takes away one plugin after the other. What does not use it still plans; what does is refused by
# name; the list of plugins lacks it and nothing else.
set -euo pipefail
prefix=$1 work=$2
rm -rf "$work"
mkdir -p "$work/away"
cp -a "$prefix" "$work/prefix"
cd "$work"
plugins=prefix/lib/tendril/plugins
run() { env -i PATH=/usr/bin:/bin HOME="$work" prefix/bin/tendril "$@"; }
names() { (cd "$plugins" && printf '%s\n' tendril-"$1"-*.so) | sed -nE "s/^tendril-$1-([a-z0-9_]+)\.so$/\1/p"; }

# scene COORDINATES OBJECTIVE SOLVER
scene() {
  printf '[rod]\nlength = "100 mm"\nbending_stiffness = "4.9e-4 N m^2"\n[[rod.actuator]]\nlimit = "2.5 N mm"\n'
  printf '[coordinates]\nplugin = "%s"\n[target]\nposition = ["97 mm", "20 mm"]\n' "$1"
  printf '[[objective]]\nplugin = "%s"\n[solver]\nplugin = "%s"\n' "$2" "$3"
}
# An objective that a free pose can have: some need a contact or a palm.
free_objective() {
  local name
  for name in $(names objective); do
    scene "$1" "$name" "$2" > try.toml
    if run describe try.toml > log 2>&1; then echo "$name"; return; fi
  done
  echo "no objective is left that suits a free pose" >&2
  return 1
}

run plugins | grep -E '^(coordinates|objective|solver) ' | cut -d: -f1 | sort > all
count=0
for file in "$plugins"/tendril-*.so; do
  [[ $(basename "$file") =~ ^tendril-([a-z]+)-([a-z0-9_]+)\.so$ ]]
  kind=${BASH_REMATCH[1]} name=${BASH_REMATCH[2]}
  grep -qx "$kind $name" all || { echo "$kind $name is not listed"; exit 1; }
  mv "$file" away/
  run plugins > listed
  grep -E '^(coordinates|objective|solver) ' listed | cut -d: -f1 | sort > left
  diff <(grep -vx "$kind $name" all) left || { echo "without $kind $name"; exit 1; }

  coordinates=$(names coordinates | head -n 1)
  solver=$(names solver | head -n 1)
  if [[ -n $coordinates && -n $solver ]]; then
    objective=$(free_objective "$coordinates" "$solver")
    scene "$coordinates" "$objective" "$solver" > other.toml
    run plan other.toml --json > plan.json || { echo "without $kind $name"; cat plan.json; exit 1; }
    grep -q '"status": "solved"' plan.json
  else
    echo "without $kind $name nothing of its kind is left to plan with"
    coordinates=${coordinates:-none} solver=${solver:-none} objective=none
  fi
  declare "$kind=$name"
  scene "$coordinates" "$objective" "$solver" > user.toml
  code=0
  run plan user.toml > log 2>&1 || code=$?
  if [[ $code != 2 ]] || ! grep -q "'$name'" log; then
    echo "a scene that needs $kind $name, which is not there: exit code $code"
    cat log
    exit 1
  fi
  mv "away/$(basename "$file")" "$file"
  count=$((count + 1))
done
echo "$count plugins, each taken away in turn"
((count == $(wc -l < all)))
