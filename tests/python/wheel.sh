#!/usr/bin/env bash
# wheel.sh PYTHON SOURCE BUILD WORK: what a new user does, without network: wheels are made, installed into an empty environment, and the
# notebook of the first hour, an objective of one's own in it, comes out there as it is kept; all that in ten minutes. Then the suite
# passes, without the source tree.
set -euo pipefail
python=$1 source=$2 build=$3 work=$4
rm -rf "$work"
mkdir -p "$work/run"
# A copy, since setuptools writes beside what it builds.
mkdir "$work/source"
cp -r "$source"/{pyproject.toml,setup.py,README.md,LICENSE,core,scripts} "$work/source"
# Sets spent: s of work that this script has let do so far, since a busy machine takes longer. Not for a shell of its own.
measure() {
  times > "$work/times"
  spent=$(awk 'NR == 2 { for (i = 1; i <= 2; ++i) { split($i, t, /[ms]/); s += 60 * t[1] + t[2] } printf "%d", s }' "$work/times")
}
clean() { env -i HOME="$work" PATH=/usr/bin:/bin LANG=C.UTF-8 "$@"; }
clean TENDRIL_BUILD_DIR="$build" "$work/source/scripts/wheelhouse" "$work/wheels" matplotlib nbconvert ipykernel pytest pint tqdm
ls "$work"/wheels/tendril-*-cp3*-linux_*.whl
# Nothing of the distribution's Python packages is seen.
"$python" -m venv "$work/venv"
clean "$work/venv/bin/pip" install --no-compile --no-index --find-links "$work/wheels" tendril[pictures] nbconvert ipykernel pytest pint tqdm > "$work/log" 2>&1 \
  || { cat "$work/log"; exit 1; }
clean "$work/venv/bin/python" -m ipykernel install --sys-prefix > "$work/log" 2>&1  # else a system's own kernel comes first
measure
installed=$spent
rm -rf "$work/source" "$work/wheels"
cp -r "$source/scenes" "$source"/tests/python "$source/docs/python-tutorial.ipynb" "$work/run"
cd "$work/run"
clean "$work/venv/bin/python" python/run_notebook.py python-tutorial.ipynb scenes
measure
echo "installed after $installed s of work, the notebook done after $spent s, at most 600 s"
((spent > 0 && spent <= 600))
for module in tendril numpy matplotlib nbconvert pytest; do
  clean "$work/venv/bin/python" -c "import $module; print($module.__file__)" | grep -F "$work/venv/lib"
done
# No library of the build is looked at: each is found inside the environment.
clean "$work/venv/bin/python" -c '
import tendril, pathlib
tendril.load("scenes/brace.toml").plan()
lines = pathlib.Path("/proc/self/maps").read_text().splitlines()
print("\n".join(sorted({line.split()[-1] for line in lines if "tendril" in line})))' > maps
if grep -vF "$work/venv" maps; then echo 'these files are not of the wheel'; exit 1; fi
grep -q 'tendril-solver-' maps
clean TENDRIL_SCENES="$work/run/scenes" "$work/venv/bin/python" -m pytest -q -p no:cacheprovider python
