#!/usr/bin/python3
"""united.py SOURCE: the sources of one folder can be compiled as one, as wheels are built: no name of an anonymous namespace stands in
two of them, but functions that differ in what they take, or beside a constant of a header."""

import collections
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
DECLARED = re.compile(
    r"^(?:template <[^\n]*>\n)?(?:\[\[[^\]]*\]\] )?"
    r"(?:(?:struct|class|enum(?: class)?|union) (?P<type>\w+)\b(?! *;)|using (?P<alias>\w+) =|"
    r"(?:(?:static|constexpr|const|inline|extern) )*[\w:]+(?:<[^\n(]*>)?(?: const)?[&*]* ?(?P<name>\w+)(?P<rest> ?[=;{\[(][^;{]*))", re.MULTILINE)


def names(text):
    """What the anonymous namespaces of a file declare at their outer level."""
    text = re.sub(r"^\}  // namespace$", "\f}", text, flags=re.MULTILINE)
    text = re.sub(r" *//[^\n]*", "", text)
    for inside in re.findall(r"^namespace \{$(.*?)\f\}$", text, re.MULTILINE | re.DOTALL):
        for match in DECLARED.finditer(inside):
            if match["name"] and match["rest"].startswith("("):
                takes = [re.sub(r"\s*\w*\s*(=.*)?$", "", one) for one in match["rest"][1:].split(")")[0].split(",")]
                yield f"{match['name']}({', '.join(takes)})"
            elif found := match["type"] or match["alias"] or match["name"]:
                yield found
                yield from re.findall(r", (\w+) =", match["rest"] or "")


folders = collections.defaultdict(lambda: collections.defaultdict(list))
for room in ("core/src", "app/src", "python/src"):
    constants = {name: header.name for header in (source / room).rglob("*.hpp")
                 for name in re.findall(r"^inline (?:constexpr|const) [^\n=]*?(\w+) =", header.read_text(), re.MULTILINE)}
    for file in sorted((source / room).rglob("*.cpp")):
        for name in set(names(file.read_text())):
            folders[file.parent][name] += [constants[name], file.name] if name in constants else [file.name]
clashes = [f"{folder.relative_to(source)}: {name} stands in {' and '.join(files)}"
           for folder, found in folders.items() for name, files in found.items() if len(files) > 1]
count = sum(len(found) for found in folders.values())
print("\n".join(clashes) or f"{count} names of anonymous namespaces, each in one source of its folder")
sys.exit(bool(clashes) or count < 900)
