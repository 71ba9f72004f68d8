#!/usr/bin/env bash
# install.sh CMAKE BUILD FIRST PREFIX SCENE SOLVER: installs into FIRST, moves it to PREFIX, and plans from there.
set -euo pipefail
cmake=$1 build=$2 first=$3 prefix=$4 scene=$5 solver=$6
rm -rf "$first" "$prefix"
"$cmake" --install "$build" --prefix "$first" > /dev/null
mv "$first" "$prefix"

cd "$prefix"
command=(env -i "$prefix/bin/tendril")
"${command[@]}" plugins --json > plugins.json
grep -q "\"directory\": \"$prefix/lib/tendril/plugins\"" plugins.json
# No run path may lead out of the prefix, least of all to where it was built.
for file in bin/* lib/*.so* lib/tendril/*/*; do
  if [[ -f $file && ! -L $file ]] && readelf -d "$file" | grep -E 'RUNPATH|RPATH' | grep -v '\[\$ORIGIN[^]]*\]'; then
    echo "$file: a run path that does not begin at \$ORIGIN" >&2
    exit 1
  fi
done
if grep -rlF "$build" lib/cmake; then
  echo "the package files above name the build directory" >&2
  exit 1
fi
# What the README links to and its commands name is there.
for file in $(grep -oE '\]\([^):#]+\)|(scenes|examples)/[a-z0-9_]+(\.toml)?' share/doc/tendril/README.md | tr -d '])('); do
  [[ -e share/doc/tendril/$file ]] || { echo "the installed README names $file, which is not there" >&2; exit 1; }
done
(cd share/doc/tendril && "${command[@]}" plan scenes/brace.toml --solver "$solver" > /dev/null)
"${command[@]}" plan "$scene" --solver "$solver" --json > plan.json
grep -q '"status": "solved"' plan.json

# What its README and its pages link to is there, and its scenes can be planned.
cd share/doc/tendril
for page in README.md docs/*.md; do
  for link in $(grep -oE '\]\([^)#: ]+[)#]' "$page" | sed 's/^](//; s/[)#]$//'); do
    [[ -e $(dirname "$page")/$link ]] || { echo "$page: $link is not installed" >&2; exit 1; }
  done
done
"${command[@]}" plan scenes/brace.toml --solver "$solver" --json > "$prefix/plan.json"
grep -q '"status": "solved"' "$prefix/plan.json"
