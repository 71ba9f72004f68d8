#!/usr/bin/env bash
# names.sh SOURCE: core, the plugin loader, the command and the benchmark name no plugin of the tree, so that one can be taken away
# or added without a change to them. The defaults of a scene are the exception, and stand in one place.
set -euo pipefail
cd "$1"
mapfile -t names < <(sed -nE 's/^ *tendril_add_plugin\(KIND [a-z]+ NAME ([a-z0-9_]+).*/\1/p' {coordinates,objectives,solvers}/CMakeLists.txt \
  solvers/*/CMakeLists.txt | sort -u)
((${#names[@]} >= 8)) || { echo "only ${#names[@]} plugins found"; exit 1; }
faults=0
for name in "${names[@]}"; do
  while IFS= read -r line; do
    case $line in
      app/src/scene/scene_tables.hpp:*'constexpr const char* default_'*) continue ;;
      # Core's own basis, which the plugin of that name hands out.
      core/include/tendril/coordinate_model.hpp:*'static constexpr const char* name = "legendre"'*) continue ;;
      # The campaign's scenes are the same for a seed whatever is installed, and its check has formulas of its own.
      bench/campaign/random_scene.cpp:* | bench/check/plan_check.cpp:*) continue ;;
      # The force of a contact is a variable of the program and a number in results, whatever weighs it.
      *'"contact_force"'*) continue ;;
    esac
    echo "$line"
    faults=$((faults + 1))
  done < <(grep -rnE --include='*.cpp' --include='*.hpp' --include=CMakeLists.txt "\"$name\"|tendril-[a-z]+-$name\b" core plugins/src \
    plugins/include plugins/CMakeLists.txt app bench)
done
echo "${#names[@]} plugins, named in $faults places"
((faults == 0))
