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
    """What a cell says, without times and addresses. A busy machine may hand on in pieces what is printed."""
    printed = "".join(output.text for output in cell.outputs if output.output_type == "stream")
    rest = [output.get("data", {}) for output in cell.outputs if output.output_type != "stream"]
    texts = ["a picture" if any(kind.startswith("image/") for kind in data) else data.get("text/plain", "") for data in rest]
    return [re.sub(r"0x[0-9a-f]+|\d+(\.\d+)? m?s\b", "", text) for text in (printed, *texts)]


code = [(one, other) for one, other in zip(kept.cells, again.cells) if one.cell_type == "code"]
for one, other in code:
    if told(one) != told(other):
        sys.exit(f"the notebook is kept with other outputs than it has now:\n{one.source}\nkept: {told(one)}\nnow: {told(other)}")
if not any(cell.outputs for cell, _ in code):
    sys.exit("the notebook is kept without outputs")
print(f"{len(code)} cells came out as they are kept")
