#!/usr/bin/python3
"""same_plans.py BENCH TENDRIL SOLVER SEEDS: random scenes that search far, each planned with a core of its own and then with more
work than the machine has cores. Everything but times has to be the same, byte for byte.

SEEDS: numbers between commas."""

import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile

bench, tendril, solver, seeds = *sys.argv[1:4], sys.argv[4].split(",")
cores = os.cpu_count()


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if "seconds" not in k and "time" not in k}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def plan(scene):
    # The limit is far away: what it does to a search is no part of the promise.
    command = [tendril, "plan", str(scene), "--json", "--solver", solver, "--set", "solver.time_limit=600"]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    if ran.returncode not in (0, 1):
        raise SystemExit(f"{scene.name}: exit {ran.returncode}\n{ran.stderr}")
    return json.dumps(without_times(json.loads(ran.stdout)), indent=1)


with tempfile.TemporaryDirectory() as folder:
    scenes = []
    for seed in seeds:
        text = subprocess.run([bench, "campaign", "--seeds", f"{seed}:{seed}", "--print-scene"], capture_output=True, text=True, check=True)
        scenes.append(pathlib.Path(folder) / f"seed_{seed}.toml")
        scenes[-1].write_text(text.stdout)
    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        idle = list(pool.map(plan, scenes))
    spinner = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        with concurrent.futures.ThreadPoolExecutor(2 * cores) as pool:
            busy = list(pool.map(plan, scenes))
    finally:
        spinner.kill()

differing = 0
for scene, a, b in zip(scenes, idle, busy):
    if a == b:
        continue
    differing += 1
    lines = [f"  {x.strip()}  |  {y.strip()}" for x, y in zip(a.splitlines(), b.splitlines()) if x != y]
    print(f"{scene.stem}: idle and busy differ:", *lines[:6], sep="\n")
print(f"{len(scenes)} scenes, {differing} with another plan on a busy machine")
sys.exit(1 if differing else 0)
