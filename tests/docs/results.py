#!/usr/bin/env python3
"""results.py COMMAND SCENES PAGE: every key of every kind of result stands on the page that documents them."""
import json
import re
import subprocess
import sys

command, scenes, page = sys.argv[1:]
RUNS = [
    ("plan", "brace.toml", "--verify"),
    ("plan", "grasp_60mm.toml", "--verify"),
    ("plan", "grasp_unequal.toml", "--verify"),
    ("plan", "trajectory.toml", "--verify"),
    ("plan", "estimate.toml", "--set", "contact.friction=0.3"),
    ("plan", "sequence.toml"),
    ("calibrate", "calibrate.toml"),
    ("plan", "clutter.toml", "--set", "solver.time_limit=0.1"),
    ("execute", "snap_through.toml", "--moments", "-0.05"),
    ("execute", "brace.toml", "--moments", "0.0025"),
    ("study", "grasp_distal_sweep.toml"),
    ("study", "trajectory.toml"),
    ("study", "paradigms.toml", "--set", 'study.targets=[["97 mm", "20 mm"]]'),
    ("describe", "brace.toml"),
]
# Names that belong to plugins and scenes, not to results.
NAMED_BY_OTHERS = {"terms", "options", "evaluations", "obstacles"}


def keys_of(value, found):
    if isinstance(value, dict):
        for key, part in value.items():
            found.add(key)
            if key not in NAMED_BY_OTHERS:
                keys_of(part, found)
    elif isinstance(value, list):
        for part in value:
            keys_of(part, found)


with open(page, encoding="utf-8") as file:
    written = set(re.findall(r"`([^`]+)`", file.read()))
found = set()
for kind, scene, *options in RUNS:
    run = subprocess.run([command, kind, f"{scenes}/{scene}", "--json", *options], capture_output=True, text=True)
    if run.returncode not in (0, 1):
        sys.exit(f"{kind} {scene}: {run.stderr}")
    keys_of(json.loads(run.stdout), found)
missing = sorted(found - written - {"schema"})
if len(found) < 100 or missing:
    sys.exit(f"{len(found)} keys found; not on the page: {', '.join(missing)}")
print(f"{len(found)} keys are documented")
