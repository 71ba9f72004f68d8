#!/usr/bin/env python3
"""citations.py SOURCE: what sources and pages cite is there, and what the pages say of time has a source.

A section of the model page exists, and a page that the sources name is one of docs/, which an installation has, too. A figure of time
depends on the machine and is not measured here: in its section, or at the head of its page, stands the program or the table that
gives it, and the program exists.
"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
ROOMS = ("core", "app", "plugins", "solvers", "objectives", "coordinates", "python", "bench", "tests", "docs", "examples")
KINDS = {".cpp", ".hpp", ".in", ".py", ".sh", ".md", ".toml"}
WRITTEN = {"report.md", "campaign.md", "completeness.md", "ablation.md"}  # by programs, into a directory of the user's
TIME = re.compile(r"(?<![\w.])(?:\d[\d.,]*|half an?|one|ten|some|tens of) (?:ns|us|ms|s|minutes?|seconds?|milliseconds?|hours?)\b")
MEASURES = re.compile(r"(tendril-[a-z-]+benchmark\b|tendril-bench\b|tendril-estimate-campaign\b)|((?:tests|scripts)/[\w./-]*\w)|(`times\.csv`|`seconds`)")
# Numbers of a scene or a limit: nothing that was measured.
NO_FIGURES = {"docs/estimate.md": [r"in 1 s, or", r"\d[.\d]* s( +\d[.\d]* s)? +\d"], "docs/results.md": [r"in 1 s or"],
              "docs/plugins.md": [r"within a minute"], "docs/scene-keys.md": [r".*"]}


def sources():
    return [source / "README.md"] + [f for room in ROOMS for f in sorted((source / room).rglob("*")) if f.suffix in KINDS]


def citations():
    headings = re.findall(r"^## (\d+)\. ", (source / "docs/model.md").read_text(), re.M)
    for file in sources():
        # A citation may go on in the next line of a comment.
        text = re.sub(r"\s*\n\s*(?:///?|#|\*)?\s*", " ", file.read_text(errors="replace"))
        for match in re.finditer(r"model\.md[`)\]]*,? sections? (\d+)(?:,? and (\d+))?", text):
            for number in filter(None, match.groups()):
                if number not in headings:
                    yield f"{file.relative_to(source)} cites section {number} of docs/model.md, which has {headings[0]} to {headings[-1]}"
        for page in re.findall(r"(?<![\w/.<-])(?:docs/)?([a-z][a-z_-]*\.md)\b", text) if file.suffix in (".hpp", ".cpp") else []:
            if "tests" not in file.parts and page not in WRITTEN and not (source / "docs" / page).exists():
                yield f"{file.relative_to(source)} names {page}, which is no page of docs/"


def figures_of_time():
    count = 0
    for page in [source / "README.md", *sorted((source / "docs").glob("*.md"))]:
        name = str(page.relative_to(source))
        head, *parts = re.split(r"^## ", page.read_text(), flags=re.M)
        for part in (head, *parts):
            text = part
            for pattern in NO_FIGURES.get(name, []):
                text = re.sub(pattern, "", text)
            found = TIME.findall(re.sub(r"\s+", " ", text))
            count += len(found)
            given = ["".join(match) for match in MEASURES.findall(part + head)]
            if found and not given:
                yield f"{name}, '{part.splitlines()[0]}': '{found[0]}' without what measures it"
            for program in given if found else []:
                if "/" in program and not (source / program).exists():
                    yield f"{name} names {program}, which is not there"
    if count < 20:
        yield f"{count} figures of time were found, expected the pages' 20 and more"


wrong = [*citations(), *figures_of_time()]
print("\n".join(wrong) or "every citation leads somewhere, every figure of time has its source")
sys.exit(bool(wrong))
