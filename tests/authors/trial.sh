#!/usr/bin/env bash
# trial.sh PACKAGES SOURCE COMPILER SOLVER: unpacks the Debian packages into a new directory, takes the source tree away, and does
# what the installed guide says. The tree is hidden by an empty file system in a mount namespace of this test's own.
set -euo pipefail
packages=$1 source=$2 compiler=$3 solver=$4
command -v dpkg-deb > /dev/null || { echo "left out: dpkg-deb is not here"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for component in tendril tendril-dev "tendril-solver-$solver"; do dpkg-deb -x "$packages/$component"_*.deb "$work/root"; done
cp "$source/tests/docs/guide.sh" "$work/guide.sh"
arguments=("$work/root/usr" "$work/trial" "$work/root/usr/share/doc/tendril/docs/plugins.md" "$compiler" "$solver")
namespace=(unshare --mount)
((EUID == 0)) || namespace=(unshare --user --map-root-user --mount)
if "${namespace[@]}" true 2> /dev/null; then
  HIDE=$source "${namespace[@]}" sh -c 'mount -t tmpfs none "$HIDE" && exec "$@"' sh "$work/guide.sh" "${arguments[@]}"
else
  echo 'the source tree is not hidden, for want of a mount namespace'
  "$work/guide.sh" "${arguments[@]}"
fi
