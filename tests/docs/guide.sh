#!/usr/bin/env bash
# guide.sh PREFIX WORK GUIDE COMPILER SOLVER: does what the guide says, in its order, with the installation in PREFIX and an
# empty environment: a block whose first line is a comment with a file's name is written to that file, a block of shell is
# run. A word that is wrong in either fails. HIDE, if set, is a directory that must not be there to be read.
set -euo pipefail
prefix=$1 work=$2 guide=$3 compiler=$4 solver=$5
rm -rf "$work"
mkdir -p "$work"
cp "$guide" "$work/guide.md"
cd "$work"
if [[ -n ${HIDE:-} && -e $HIDE/CMakeLists.txt ]]; then
  echo "$HIDE is still there" >&2
  exit 1
fi

# Makes one script of the guide, so that what it says is run in one go and stops at the first fault.
awk '
  function close_block() { if (kind == "file") print "END_OF_BLOCK"; kind = "" }
  /^```sh$/ { kind = "sh"; next }
  /^```(cpp|toml|cmake)$/ { kind = "first"; next }
  /^```/ { close_block(); next }
  kind == "first" {
    if (NF != 2 || ($1 != "//" && $1 != "#")) { print "guide.sh: a block that begins with: " $0 > "/dev/stderr"; exit 1 }
    print "cat > " $2 " <<'\''END_OF_BLOCK'\''"; kind = "file"; files++
  }
  kind == "file" { print }
  kind == "sh" { print "echo \"+ " $0 "\" | tr -d \"\\047\""; print; commands++ }
  END { print "# " files " files, " commands " commands" }
' guide.md > run.sh
tail -n 1 run.sh
grep -q '^tendril plan' run.sh
code=0
start=$SECONDS
env -i PATH="$prefix/bin:/usr/bin:/bin" HOME="$work" CXX="$compiler" CMAKE_GENERATOR=Ninja CMAKE_PREFIX_PATH="$prefix" \
  CXXFLAGS='-O1 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror' CLICOLOR_FORCE= \
  bash -euo pipefail run.sh > log 2>&1 || code=$?
[[ $code == 0 ]] || { tail -n 60 log; exit 1; }
echo "the whole guide took $((SECONDS - start)) s"
for source in */*.cpp; do
  lines=$(wc -l < "$source")
  name=$(basename "$source" .cpp)
  echo "$source: $lines lines"
  ((lines < 50)) || { echo "expected fewer than 50" >&2; exit 1; }
  PATH="$prefix/bin:$PATH" tendril plugins --plugin-dir "$name/build" | grep "^[a-z]* $name: "
done
