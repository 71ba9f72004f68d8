#!/usr/bin/env bash
# wheel.sh PYTHON SOURCE BUILD WORK: wheels are made without network, installed into an empty environment, and pass the suite there
# without the source tree.
set -euo pipefail
python=$1 source=$2 build=$3 work=$4
rm -rf "$work"
mkdir -p "$work/run"
# A copy, since setuptools writes beside what it builds.
mkdir "$work/source"
cp -r "$source"/{pyproject.toml,setup.py,README.md,LICENSE,core,scripts} "$work/source"
clean() { env -i HOME="$work" PATH=/usr/bin:/bin LANG=C.UTF-8 "$@"; }
clean TENDRIL_BUILD_DIR="$build" "$work/source/scripts/wheelhouse" "$work/wheels" matplotlib pytest pint tqdm
ls "$work"/wheels/tendril-*-cp3*-linux_*.whl
# Nothing of the distribution's Python packages is seen.
"$python" -m venv "$work/venv"
clean "$work/venv/bin/pip" install --no-index --find-links "$work/wheels" tendril[pictures] pytest pint tqdm > "$work/log" 2>&1 \
  || { cat "$work/log"; exit 1; }
rm -rf "$work/source" "$work/wheels"
cp -r "$source/scenes" "$source"/tests/python "$work/run"
cd "$work/run"
for module in tendril numpy matplotlib pytest; do
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
