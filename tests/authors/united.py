#!/usr/bin/python3
"""united.py SOURCE: the sources of one folder can be compiled as one: no name of an anonymous namespace stands in
two of them, but functions that differ in what they take and aliases that do not, or beside a constant of a header."""

import collections
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
DECLARED = re.compile(
    r"^(?![A-Z_]+\()(?:template <[^\n]*>\n)?(?:\[\[[^\]]*\]\] )?"
    r"(?:(?:struct|class|enum(?: class)?|union) (?P<type>\w+)\b(?! *;)|using (?P<alias>\w+) = (?P<meaning>[^;]*)|"
    r"(?:(?:static|constexpr|const|inline|extern) )*[\w:]+(?:<[^\n(]*>)?(?: const)?[&*]* ?(?P<name>\w+)(?P<rest> ?[=;{\[(][^;{]*))", re.MULTILINE)


def names(text):
    """What the anonymous namespaces of a file declare at their outer level; of an alias also what it stands for."""
    text = re.sub(r"^\}  // namespace$", "\f}", text, flags=re.MULTILINE)
    text = re.sub(r'R"\w*\(.*?\)\w*"|"(?:[^"\\\n]|\\.)*"', '""', text, flags=re.DOTALL)
    text = re.sub(r" *//[^\n]*", "", text)
    for inside in re.findall(r"^namespace \{$(.*?)\f\}$", text, re.MULTILINE | re.DOTALL):
        for match in DECLARED.finditer(inside):
            if match["name"] and match["rest"].startswith("("):
                takes = [re.sub(r"\s*\w*\s*(=.*)?$", "", one) for one in match["rest"][1:].split(")")[0].split(",")]
                yield f"{match['name']}({', '.join(takes)})", None
            elif found := match["type"] or match["alias"] or match["name"]:
                yield found, match["meaning"]
                yield from ((more, None) for more in re.findall(r", (\w+) =", match["rest"] or ""))


def of_headers(headers, pattern):
    return {name: header.name for header in headers for name in re.findall(pattern, header.read_text(), re.MULTILINE)}


folders = collections.defaultdict(lambda: collections.defaultdict(list))
# Of plugins and fixtures each source is a library of its own.
for room in ("core/src", "app/src", "python/src", "plugins/src", "plugins/kit", "solvers/nlopt", "bench", *sorted(source.glob("tests/*/"))):
    constants = of_headers((source / room).rglob("*.hpp"), r"^inline (?:constexpr|const) [^\n=]*?(\w+) =")
    for folder in {file.parent for file in (source / room).rglob("*.cpp")} - set((source / room).rglob("fixtures")):
        shared = constants | of_headers(folder.glob("*.hpp"), r"^(?:struct|class|enum class) (\w+)\b(?! *;)")
        for file in sorted(folder.glob("*.cpp")):
            if file.name.endswith("_plugin.cpp") and "tests" in file.parts:
                continue
            for name, meaning in set(names(file.read_text())):
                if name in shared:
                    folders[folder][name].append((shared[name], None))
                folders[folder][name].append((file.name, meaning))
for found in folders.values():
    for name in [name for name in found if "(" in name]:
        if (plain := name.split("(")[0]) in found:
            found[plain] += found[name]
clashes = [f"{folder.relative_to(source)}: {name} stands in {' and '.join(file for file, _ in uses)}"
           for folder, found in folders.items() for name, uses in found.items()
           if len(uses) > 1 and (None in (meanings := {meaning for _, meaning in uses}) or len(meanings) > 1)]
count = sum(len(found) for found in folders.values())
print("\n".join(clashes) or f"{count} names of anonymous namespaces, each in one source of its folder")
sys.exit(bool(clashes) or count < 900)
