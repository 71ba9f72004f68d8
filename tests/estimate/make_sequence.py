#!/usr/bin/env python3
"""make_sequence.py COMMAND SCENES: writes SCENES/sequence.csv, the arm of SCENES/brace.toml between its peg and another one
above its tip while its moment goes up and down again, as `tendril execute` has it, with normal noise of 0.05 mm."""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

FRAMES, STEP = 48, 0.04  # s
NOISE = 0.05  # mm
ABOVE = '[[obstacle]]\nshape = "circle"\ncenter = ["80 mm", "36 mm"]\nradius = "8 mm"\n\n'

command, scenes = sys.argv[1], pathlib.Path(sys.argv[2])
times = [STEP * k for k in range(FRAMES)]
moments = [round(5.0 - 4.0 * math.cos(2.0 * math.pi * k / (FRAMES - 1)), 3) for k in range(FRAMES)]  # N mm
with tempfile.TemporaryDirectory() as directory:
    scene = pathlib.Path(directory, "scene.toml")
    scene.write_text((scenes / "brace.toml").read_text().replace("[contact]\n", ABOVE + "[contact]\n", 1))
    run = subprocess.run([command, "execute", scene, "--json", "--moments", "; ".join(f"{m} N mm" for m in moments)],
                         capture_output=True, text=True, check=True)


def place(backbone, s):
    """Cubic between neighbouring points of the result, which knows their angles."""
    a, b = next((a, b) for a, b in zip(backbone, backbone[1:]) if s <= b[0] + 1e-12)
    h = b[0] - a[0]
    u = (s - a[0]) / h
    weights = (2 * u**3 - 3 * u**2 + 1, 3 * u**2 - 2 * u**3, h * (u**3 - 2 * u**2 + u), h * (u**3 - u**2))
    return [sum(w * v for w, v in zip(weights, (a[i], b[i], turn(a[3]), turn(b[3]))))
            for i, turn in ((1, math.cos), (2, math.sin))]


steps = json.loads(run.stdout)["steps"]
noise = random.Random(1)
lines = ["# `tendril execute` of scenes/brace.toml with a second peg, with normal noise of 0.05 mm on x and y: written by",
         "# tests/estimate/make_sequence.py", "time [s], moment_1 [N mm], s [mm], x [mm], y [mm]"]
for time, moment, step in zip(times, moments, steps):
    for s in range(5, 101, 5):
        x, y = (1e3 * v + noise.gauss(0.0, NOISE) for v in place(step["backbone"], 1e-3 * s))
        lines.append(f"{time:.2f}, {moment:g}, {s}, {x:.3f}, {y:.3f}")
(scenes / "sequence.csv").write_text("\n".join(lines) + "\n")
for time, step in zip(times, steps):
    print(f"{time:.2f}", *(f"{1e3 * c['force']:.2f} mN at {1e3 * c['arc_length']:.2f} mm" for c in step["contacts"]))
