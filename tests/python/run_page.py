"""run_page.py SOURCE PAGE...: runs every Python block of the pages, those of one page one after the other in one namespace, in
a folder beside the scenes. What a comment `# -> text` claims of a line's value is compared."""

import os
import pathlib
import re
import shutil
import sys

source = pathlib.Path(sys.argv[1])
work = pathlib.Path.cwd() / "pages"
# A study of another version would go on where this one begins.
shutil.rmtree(work, ignore_errors=True)
work.mkdir()


def run(block, names, where):
    """The lines of a block; a line with a claim is evaluated, and its value's text has to begin as claimed."""
    pending = []
    for line in [*block.splitlines(), ""]:
        code, _, claim = line.partition("  # -> ")
        if not claim:
            pending.append(line)
            continue
        exec(compile("\n".join(pending), where, "exec"), names)
        pending = []
        found = repr(eval(compile(code.strip(), where, "eval"), names))
        if not found.startswith(claim.strip().removesuffix("...")):
            sys.exit(f"{where}: {code.strip()} is {found}, the page says {claim}")
    exec(compile("\n".join(pending), where, "exec"), names)


def main():
    total = 0
    if not (work / "scenes").exists():
        (work / "scenes").symlink_to(source / "scenes")
    for page in sys.argv[2:]:
        text = (source / page).read_text()
        names = {"__name__": "page"}
        os.chdir(work)
        blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        if not blocks:
            sys.exit(f"{page}: no block of Python found")
        for i, block in enumerate(blocks):
            run(block, names, f"{page}, block {i + 1}")
            total += 1
    print(f"{total} blocks ran")


main()
