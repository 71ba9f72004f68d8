#!/usr/bin/env bash
# readme_plugin.sh SOURCE BUILD WORK SOLVER: builds the plugin that the README shows, outside the tree, and plans a scene with it.
set -euo pipefail
source=$1 build=$2 work=$3 solver=$4
rm -rf "$work"
mkdir -p "$work/level_tip"

# An indented block runs from its first line to the next line that is not indented.
block() {
  awk -v first="    $1" '$0 == first { on = 1 } on && /^[^ ]/ { exit } on { sub(/^    /, ""); print }' "$source/README.md"
}
block '// level_tip.cpp' | awk '/^# CMakeLists.txt$/ { exit } { print }' > "$work/level_tip/level_tip.cpp"
block '# CMakeLists.txt' > "$work/level_tip/CMakeLists.txt"
grep -q TENDRIL_PLUGIN "$work/level_tip/level_tip.cpp"
grep -q tendril_add_plugin "$work/level_tip/CMakeLists.txt"

cmake -S "$work/level_tip" -B "$work/level_tip/build" -G Ninja -Dtendril_DIR="$build" > "$work/log" || { cat "$work/log"; exit 1; }
cmake --build "$work/level_tip/build" >> "$work/log" || { cat "$work/log"; exit 1; }

# A free arm whose only wish is a level tip: the plan must reach it.
sed -e '/^\[\[objective\]\]/,$d' "$source/scenes/free.toml" > "$work/scene.toml"
printf '[[objective]]\nplugin = "level_tip"\n\n[solver]\nplugin = "%s"\n' "$solver" >> "$work/scene.toml"
"$build/bin/tendril" plan "$work/scene.toml" --plugin-dir "$work/level_tip/build" --json > "$work/plan.json"
grep -q '"status": "solved"' "$work/plan.json"
grep -q '"level_tip"' "$work/plan.json"
