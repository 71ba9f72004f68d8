"""speed.py FOLLOW_TIME SCENES: what the package costs beside the library: the times of docs/python.md, in seconds of the thread that
works, the best of several runs, those of both sides in turn, so that a busy machine tells the same."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

import tendril

STEPS, REPEATS, ROUNDS = 1000, 7, 5
IMPORT = "import time; begin = time.process_time(); import tendril; print(time.process_time() - begin)"
program, scenes = sys.argv[1], pathlib.Path(sys.argv[2])
brace = tendril.load(scenes / "brace.toml")


def best(work):
    times = []
    for _ in range(REPEATS):
        begin = time.thread_time()
        work()
        times.append(time.thread_time() - begin)
    return min(times)


def follow():
    for i in range(STEPS):
        problem.follow((0.097, 0.02 - 1e-5 * (i % 100)))


problem = brace.problem()
follow()
in_cpp = [program, scenes / "brace.toml", str(STEPS), str(REPEATS)]
rounds = [(best(follow), float(subprocess.run(in_cpp, capture_output=True, check=True).stdout)) for _ in range(ROUNDS)]
here, there = map(min, zip(*rounds))

calls = 0


@tendril.objective("own_target", reads=["tip_position", "target"])
def own_target(x):
    global calls
    calls += 1
    return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]


first, *others = brace["objective"]
own = brace.copy({"objective": [{**first, "plugin": "own_target"}, *others]})
own.plan()
per_plan = calls
term = (best(own.plan) - best(brace.plan)) / per_plan
with tempfile.TemporaryDirectory() as compiled:  # as an installed package is
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled, "PYTHONDONTWRITEBYTECODE": ""}
    importing = min(float(subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, check=True, env=environment).stdout)
                    for _ in range(REPEATS))

measured = {"following, from Python per C++": (here / there, 1.3, ""), "a term in Python, an evaluation": (1e6 * term, 30.0, " us"),
            "import": (1e3 * importing, 60.0, " ms")}
for name, (value, most, unit) in measured.items():
    print(f"{name}: {value:.3g}{unit}, at most {most:g}{unit}")
print(f"({1e6 * there / STEPS:.1f} us a step in C++, {1e6 * here / STEPS:.1f} us in Python, {per_plan} evaluations a plan)")
sys.exit(any(value > most for value, most, _ in measured.values()))
