#!/usr/bin/env bash
# reference.sh TENDRIL DOCS: the page of all keys is what this tendril would write; the manual page and the completion know
# every command and every option that --help lists.
set -euo pipefail
tendril=$1 docs=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset TENDRIL_PLUGIN_PATH
"$tendril" reference keys > "$work/keys"
diff -u "$docs/scene-keys.md" "$work/keys" || { echo "docs/scene-keys.md is not current: tendril reference keys > docs/scene-keys.md"; exit 1; }

"$tendril" reference man > "$work/tendril.1"
if command -v groff > /dev/null; then
  groff -man -Tutf8 -ww "$work/tendril.1" > "$work/man" 2> "$work/warnings"
  [[ ! -s $work/warnings ]] || { cat "$work/warnings"; exit 1; }
else
  echo 'the look of the manual page is left out: groff is not here'
fi
sed 's/\\-/-/g' "$work/tendril.1" > "$work/man.plain"
"$tendril" reference bash > "$work/completion"
source "$work/completion"

# complete LINE: what bash would offer at the end of LINE, one a line.
complete_line() {
  COMPREPLY=()
  COMP_LINE=$1 COMP_POINT=${#1} COMP_WORDBREAKS=$' \t\n=:'
  set +e  # as in an interactive shell
  _tendril
  set -e
  printf '%s\n' "${COMPREPLY[@]}" | sed 's/ *$//'
}
expect() {
  complete_line "$1" > "$work/offered"
  grep -qxF -- "$2" "$work/offered" || { echo "'$1' does not offer '$2' but:"; cat "$work/offered"; exit 1; }
}
mapfile -t commands < <("$tendril" --help | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 }')
((${#commands[@]} >= 7))
count=0
for command in "${commands[@]}"; do
  expect 'tendril ' "$command"
  grep -q "^\.SS $command\$" "$work/man.plain"
  # Options begin a line of their own; the texts beside them name others.
  mapfile -t options < <("$tendril" "$command" --help | sed -nE 's/^  (-h,)?(--[a-z-]+).*/\2/p')
  for option in "${options[@]}"; do
    expect "tendril $command --" "$option"
    [[ $option == --help ]] || grep -qE "^\.B $option( |\$)" "$work/man.plain" || { echo "manual page: no $option"; exit 1; }
    count=$((count + 1))
  done
done
echo "${#commands[@]} commands and $count options in the manual page and the completion"
cd "$work"
touch some.toml other.txt
expect 'tendril plan so' some.toml
expect 'tendril plan some.toml --set contact.mo' contact.mode=avoid
expect 'tendril plan some.toml --set contact.mode=' avoid
expect 'tendril new ob' objective
if complete_line 'tendril plan ot' | grep -q .; then echo 'a text file is offered for a scene'; exit 1; fi
