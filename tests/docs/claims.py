#!/usr/bin/env python3
"""claims.py COMMAND SOURCE WORK: the numbers that the pages state are those that the command gives now.

A claim is a page, the text around its numbers with {} for each of them, and where they come from. A number has to be the
given one, rounded to the digits that stand there; "below {}" and the like are bounds.
"""
import functools
import json
import math
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
from decimal import Decimal

command, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
# A study of another version would go on where this one begins.
shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
NUMBER = r"(-?\d+(?:\.\d+)?(?:e-?\d+)?)"
mm, mN, Nmm = 1e3, 1e3, 1e3


@functools.lru_cache(None)
def run(line):
    """The result of a command of the page, as JSON; a plan that is not solved has one, too."""
    words = [w.replace("WORK", str(work)) for w in shlex.split(line)]
    done = subprocess.run([command, *words, "--json"], cwd=source, capture_output=True, text=True, timeout=300)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{line}: exit code {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


@functools.lru_cache(None)
def study(scene, coordinates="legendre"):
    directory = work / f"{scene}_{coordinates}"
    subprocess.run([command, "study", f"scenes/{scene}.toml", "--coordinates", coordinates, "--output", str(directory), "--jobs", "2"],
                   cwd=source, capture_output=True, timeout=300, check=True)
    return json.loads((directory / "study.json").read_text())


def group(mode, limit, what):
    found = [g for g in study("paradigms")["groups"] if g["mode"] == mode and abs(g["limit"] - limit) < 1e-9]
    return found[0][what]


def tip_errors(mode):
    return [group(mode, limit, "tip_error")["mean"] * mm for limit in (0.010, 0.0025)]


def friction_misses():
    def of(state):
        return run(f"plan scenes/brace.toml --set contact.friction=0.6 --set contact.friction_state={state}")

    def most(state):
        return max(s["target_error"] for s in of(state)["friction_range"]) * mm

    return [of("range")["target_error"] * mm, most("range"), most("worst"), of("any")["target_error"] * mm]


def snap():
    run("execute scenes/snap_through.toml --moments '100 N mm' --output WORK/up")
    return run("execute scenes/snap_through.toml --moments='-50 N mm' --start WORK/up/result.json")["snaps"][0]


def axial(change):
    cases = study("grasp_distal_sweep")["cases"]
    return [c["axial_force"] / 2 for c in cases if abs(c["moment_change"] - change) < 1e-9][0]


def grasps(what, coordinates="legendre"):
    return [abs(what(c)) for c in study("grasp_sizes", coordinates)["cases"]]


def along_axis(coordinates):
    return max(grasps(lambda c: c["axial_force"], coordinates))


def rubbing_effort(friction):
    """Of the grasp of 75 mm at 10 N."""
    any_state = " --set contact.friction_state=any" if friction else ""
    return run("plan scenes/grasp_sizes.toml --set 'gripper.object_diameter=75 mm' --set 'contact.max_force=10 N' "
               f"--set contact.friction={friction}{any_state}")["terms"]["actuation_effort"]


BRACE = "plan scenes/brace.toml"
VERIFIED = BRACE + " --verify"
EXECUTED = "execute scenes/brace.toml --moments '2.5 N mm'"
PCC = VERIFIED + " --coordinates pcc"
ESTIMATE = "plan scenes/estimate.toml"


def rod_length():
    return max(p[0] for p in run(BRACE)["backbone"])


def estimated():
    c = run(ESTIMATE)["contacts"][0]
    return [c["force"] * mN, c["force_error"] / c["force"] * 100, c["arc_length"] * mm, c["arc_length_error"] * mm,
            c["correlation"], *[v * mm for v in c["point"]], *c["normal"]]


SEQUENCE = "plan scenes/sequence.toml"


def followed(number):
    """First and last time and frames of a contact, its least and largest force, where it begins and ends."""
    there = [(f["time"], c) for f in run(SEQUENCE)["frames"] for c in f["contacts"] if c["number"] == number]
    forces = [c["force"] * mN for _, c in there]
    return [number, there[0][0], there[-1][0], len(there), min(forces), max(forces), there[0][1]["arc_length"] * mm,
            there[-1][1]["arc_length"] * mm]


def made_sequence():
    """What tests/estimate/make_sequence.py carried out: forces and places on the second peg, and on the first one at the ends."""
    scene = (source / "scenes/brace.toml").read_text()
    peg = '[[obstacle]]\nname = "second"\nshape = "circle"\ncenter = ["80 mm", "36 mm"]\nradius = "8 mm"\n\n[contact]\n'
    (work / "pegs.toml").write_text(scene.replace("[contact]\n", peg, 1))
    moments = "; ".join(f"{5.0 - 4.0 * math.cos(2.0 * math.pi * k / 47):.3f} N mm" for k in range(48))
    steps = run(f"execute WORK/pegs.toml --moments '{moments}'")["steps"]
    second = [c for s in steps for c in s["contacts"] if c["obstacle"] == "second"]
    forces, places = [c["force"] * mN for c in second], [c["arc_length"] * mm for c in second]
    first = steps[0]["contacts"][0]
    return [min(forces), max(forces), min(places), max(places), first["force"] * mN, first["arc_length"] * mm]


def page_size():
    """kB, to tens of them, of the page of a trajectory."""
    run("plan scenes/trajectory.toml --figure WORK/page.html")
    return round((work / "page.html").stat().st_size / 1e3, -1)


def tolerance(name):
    header = (source / "core/include/tendril/tolerances.hpp").read_text()
    return float(re.search(rf"double {name} = ([\d.e-]+);", header).group(1))


def lift(more=""):
    """mm that the tip rises for each mm of the peg's radius."""
    found = run("sensitivity scenes/brace.toml 'obstacle[0].radius' " + more)
    return found["numbers"][0]["derivatives"][[q["name"] for q in found["quantities"]].index("tip.y")]


def error_bars():
    u = run(BRACE + " --set 'rod.bending_stiffness=4.9e-4 N m^2 +- 5 %' --set 'obstacle.0.radius=8 mm +- 0.2 mm'")["uncertainty"]
    return [u["tip"]["x"] * mm, u["tip"]["y"] * mm, u["forces"][0] * mN, u["shares"]["obstacle[0].radius"] * 100,
            u["shares"]["rod.bending_stiffness"] * 100]


def hysteresis():
    ways = run("execute scenes/brace.toml --set contact.friction=0.3 --moments '0; 1.2 N mm; 2.5 N mm; 1.2 N mm; 0'")["steps"]
    return [ways[i]["tip"][axis] * mm for i in (1, 3) for axis in "xy"]


def steps(method):
    return sum(s["method"] == method for s in run("plan scenes/trajectory.toml")["steps"])


CLAIMS = [
    ("README.md", "An arm of {} mm", lambda: [rod_length() * mm]),
    ("README.md", "in free space, where the tip ends at {} mm above",
     lambda: [run(BRACE + " --set contact.mode='\"ignore\"'")["tip"]["y"] * mm]),
    ("README.md", "pushes with {} mN", lambda: [run(BRACE)["contacts"][0]["force"] * mN]),
    ("README.md", "the tip comes within {} mm of the target", lambda: [run(BRACE)["target_error"] * mm]),
    ("README.md", "along a path, {} of {} steps without a call of the solver",
     lambda: [steps("followed"), len(run("plan scenes/trajectory.toml")["steps"])]),
    ("README.md", "All {} plans are certified", lambda: [sum(c["status"] == "solved" for c in study("paradigms")["cases"])]),
    ("README.md", "where they end to {} of the length",
     lambda: [max(g["largest_model_error"] for g in study("paradigms")["groups"]) / rod_length()]),
    ("README.md", "| without the peg, executed with it | {} mm | {} mm |", lambda: tip_errors("ignore_then_execute")),
    ("README.md", "| avoiding the peg | {} mm | {} mm, below it |", lambda: tip_errors("avoid")),
    ("README.md", "| using the peg | {} mm | {} mm |", lambda: tip_errors("allow")),
    ("README.md", "its tip ends less than {} m from", lambda: [("below", run(VERIFIED)["model_error"])]),
    ("docs/execution.md", "the tip comes to ({}, {}) mm, with {} mN at {} mm along the arm",
     lambda: [run(EXECUTED)["tip"]["x"] * mm, run(EXECUTED)["tip"]["y"] * mm, run(EXECUTED)["contacts"][0]["force"] * mN,
              run(EXECUTED)["contacts"][0]["arc_length"] * mm]),
    ("docs/estimate.md", "(The points were made with {} mN at {} mm",
     lambda: [run(EXECUTED)["contacts"][0]["force"] * mN, run(EXECUTED)["contacts"][0]["arc_length"] * mm]),
    ("docs/model.md", "until its tip rests at ({}, {}) mm",
     lambda: [run("execute scenes/tentacle.toml")["tip"][axis] * mm for axis in "xy"]),
    ("docs/grasps.md", "hangs from the palm with them, at {} and {} kPa",
     lambda: [pressure / 1e3 for pressure in run("plan scenes/silicone_grasp.toml")["pressures"]]),
    ("docs/grasps.md", "the fingers keep a margin of {}.",
     lambda: [run("plan scenes/silicone_grasp.toml")["certificate"]["out_of_plane"]]),
    ("docs/execution.md", "snapping through at {} N mm; in units of EI/L that is {}.",
     lambda: [snap()["moments"][0] * Nmm, snap()["moments"][0] / snap_unit()]),
    ("docs/execution.md", "the tip is at ({}, {}) mm on the way up and at ({}, {}) mm on the way down", hysteresis),
    ("docs/execution.md", "below {} m for `brace.toml`, {} mm with `--coordinates pcc`",
     lambda: [("below", run(VERIFIED)["model_error"]), run(PCC)["model_error"] * mm]),
    ("docs/friction.md", "misses the target by {} mm, with friction by up to {} mm; the plan for the worst state by up to {} mm, "
                         "and the one for any state by {} mm", friction_misses),
    ("docs/estimate.md", "1 {} mN {} % {} mm {} mm {} ({}, {}) mm ({}, {})", estimated),
    ("docs/estimate.md", "{} {} s {} s {} {} mN {} mN {} mm {} mm {} {} s {} s {} {} mN {} mN {} mm {} mm {} {} s {} s {} {} mN {} mN "
     "{} mm {} mm", lambda: followed(1) + followed(2) + followed(3)),
    ("docs/estimate.md", "made with {} to {} mN on the second peg, at {} to {} mm, and with {} mN at {} mm in the first", made_sequence),
    ("docs/drawing.md", "The trajectory of {} steps takes {} kB",
     lambda: [len(run("plan scenes/trajectory.toml")["steps"]), page_size()]),
    ("docs/sensitivity.md", "lifts the tip under held moments by {} mm; planned anew it rises by {} mm",
     lambda: [lift("--held"), lift()]),
    ("docs/sensitivity.md", "{} mm, {} mm and {} mN here, and the share of each input in the variance of the tip's place, {} % of the "
     "radius and {} % of the stiffness", error_bars),
    ("docs/grasps.md", "All {} diameters", lambda: [sum(grasps(lambda c: c["status"] == "solved")) / 2]),
    ("docs/grasps.md", "planned at the limit to {} N and with less than {} N along the axis",
     lambda: [("below", max(grasps(lambda c: c["contact_force"] - c["force_limit"]))),
              ("below", max(grasps(lambda c: c["planned_axial_force"])))]),
    ("docs/grasps.md", "order 6 leaves up to {} N along the axis and `psc`, with its three functions per piece, up to {} N",
     lambda: [along_axis("legendre"), along_axis("psc")]),
    *(("docs/results.md", f"| `{key}` | {told} {{}} |", lambda name=name: [tolerance(name)]) for key, told, name in (
        ("equilibrium", "largest residual of the equilibrium |", "equilibrium"),
        ("bounds", "largest excess over a limit; of moments that were given to `execute` it is told and fails nothing |", "bounds"),
        ("penetration", "proven depth of the rod in an obstacle |", "penetration"),
        ("complementarity", "largest of the smaller of gap and force of a contact |", "complementarity"),
        ("closest_point", "largest product of tangent and normal at a contact |", "closest_point"),
        ("force_balance", "force along a grasp's axis; 0 for a pose |", "balance"))),
    ("docs/results.md", "the kind asked for | {} |", lambda: [tolerance("stationarity")]),
    ("docs/results.md", "| least margin; above {} |", lambda: [tolerance("stability")]),
    ("docs/results.md", "knows the rod's torsion; -{} or above", lambda: [tolerance("out_of_plane")]),
    ("docs/results.md", "the gap along the rod; above {},", lambda: [tolerance("convexity")]),
    ("docs/grasps.md", "({} mm at {} N: {} to {} of the objective)", lambda: [75, 10, rubbing_effort(0), rubbing_effort(0.3)]),
    ("docs/grasps.md", "push it away from the palm with {} N per finger, {} N mm more pull it in with {} N",
     lambda: [axial(0.010), 10, -axial(-0.010)]),
]


def snap_unit():
    """EI/L of the scene, which gives its length in millimetres."""
    text = (source / "scenes/snap_through.toml").read_text()
    value = lambda key: float(re.search(rf'^{key} = "([\d.e-]+) ', text, re.M).group(1))
    return value("bending_stiffness") / value("length") * mm


def agrees(said, value):
    if isinstance(value, tuple):
        return value[1] < float(said)
    exponent = Decimal(said).as_tuple().exponent
    return abs(Decimal(said) - Decimal(value)) <= Decimal("0.5000001") * Decimal(1).scaleb(exponent)


failed = 0
for page, text, numbers in CLAIMS:
    words = re.sub(r"\s+", " ", (source / page).read_text())
    pattern = NUMBER.join(re.escape(part) for part in text.split("{}"))
    found = re.search(pattern, words)
    if not found:
        print(f"{page}: '{text}' does not stand there any more")
        failed += 1
        continue
    values = numbers()
    if len(values) != len(found.groups()):
        raise SystemExit(f"{text}: {len(values)} values for {len(found.groups())} numbers")
    for said, value in zip(found.groups(), values):
        if not agrees(said, value):
            print(f"{page}: '{found.group(0)}' says {said}, the command gives {value}")
            failed += 1
print(f"{len(CLAIMS)} claims, {failed} that do not hold")
sys.exit(1 if failed else 0)
