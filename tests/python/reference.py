"""reference.py [PAGE]: the reference of the package, made of its docstrings, as Markdown on standard output; with a page,
whether that is what it says."""

import contextlib
import inspect
import io
import re
import sys

import tendril


def text_of(thing, indent=""):
    """The docstring as a paragraph; what stands indented in it becomes code."""
    lines = (inspect.getdoc(thing) or "").strip().splitlines()
    return "\n".join(indent + line for line in lines)


def signature_of(thing):
    """The signature without the package's own module names."""
    try:
        signature = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    return re.sub(r"tendril\._\w+\.|typing\.|collections\.abc\.", "", signature).replace("'", "")


def members_of(kind):
    """Public methods and properties with a docstring that the class itself, or one of the package above it, brings."""
    for name, member in inspect.getmembers(kind):
        owner = next((base for base in kind.__mro__ if name in vars(base)), None)
        if name.startswith("_") or owner is None or not owner.__module__.startswith("tendril"):
            continue
        if isinstance(member, property) or callable(member):
            yield name, member


def write():
    print("# Reference of the Python package\n")
    print("Made of the docstrings by `tests/python/reference.py`; a test compares. [docs/python.md](python.md) is the guide.")
    inherited = {name for name, _ in members_of(tendril.Result)}
    for name in tendril.__all__:
        thing = getattr(tendril, name)
        if name.startswith("__"):
            continue
        is_class = inspect.isclass(thing)
        print(f"\n## {name}{'' if is_class else signature_of(thing)}\n\n{text_of(thing)}")
        if not is_class:
            continue
        for member_name, member in members_of(thing):
            if thing is not tendril.Result and issubclass(thing, tendril.Result) and member_name in inherited:
                if vars(thing).get(member_name) is None:
                    continue
            if hasattr(tuple, member_name) or not inspect.getdoc(member):
                continue
            shown = "" if isinstance(member, property) else signature_of(member)
            print(f"\n- `{member_name}{shown}`\n{text_of(member, '  ')}")


def main():
    if len(sys.argv) < 2:
        return write()
    made = io.StringIO()
    with contextlib.redirect_stdout(made):
        write()
    with open(sys.argv[1], encoding="utf-8") as page:
        if page.read() != made.getvalue():
            sys.exit(f"{sys.argv[1]} is not what the docstrings say; make it anew with tests/python/reference.py")
    print("the page says what the docstrings say")


main()
