"""run_notebook.py NOTEBOOK SCENES: executes the notebook as it stands, beside the scenes, and asks whether every output that it is
kept with comes again: texts as they are, pictures where there were pictures."""

import pathlib
import re
import shutil
import sys

import nbformat
from nbconvert.preprocessors import ExecutePreprocessor

file, scenes = map(pathlib.Path, sys.argv[1:])
work = pathlib.Path.cwd() / "notebook"
shutil.rmtree(work, ignore_errors=True)
shutil.copytree(scenes, work)
kept = nbformat.read(file, as_version=4)
again = nbformat.read(file, as_version=4)
for cell in again.cells:
    if cell.cell_type == "code":
        cell.outputs, cell.execution_count = [], None
ExecutePreprocessor(timeout=300, kernel_name="python3").preprocess(again, {"metadata": {"path": str(work)}})


def told(cell):
    """What a cell says, without times and addresses."""
    for output in cell.outputs:
        data = output.get("data", {"text/plain": output.get("text", "")})
        if any(kind.startswith("image/") for kind in data):
            yield "a picture"
        else:
            yield re.sub(r"0x[0-9a-f]+|\d+(\.\d+)? m?s\b", "", data.get("text/plain", ""))


code = [(one, other) for one, other in zip(kept.cells, again.cells) if one.cell_type == "code"]
for one, other in code:
    if list(told(one)) != list(told(other)):
        sys.exit(f"the notebook is kept with other outputs than it has now:\n{one.source}\nkept: {list(told(one))}\nnow: {list(told(other))}")
if not any(cell.outputs for cell, _ in code):
    sys.exit("the notebook is kept without outputs")
print(f"{len(code)} cells came out as they are kept")
