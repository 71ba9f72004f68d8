"""What Python gives is the command's own JSON, bit by bit but for the times."""

import json
import subprocess
import sys

import numpy as np
import pytest

import tendril
from tendril._command import command_path

TIMES = {"seconds", "seconds_evaluating", "maxtime"}


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(part) for key, part in value.items() if key not in TIMES}
    return [without_times(part) for part in value] if isinstance(value, list) else value


def command(*arguments):
    run = subprocess.run([command_path(), *map(str, arguments), "--json"], capture_output=True, text=True)
    assert run.returncode in (0, 1), run.stderr
    return json.loads(run.stdout)


def same(result, document):
    assert json.dumps(without_times(result.to_dict())) == json.dumps(without_times(document))


@pytest.mark.parametrize("name", ["brace", "avoid", "clutter", "ledge", "table", "two_pegs", "grasp_60mm", "grasp_unequal",
                                  "trajectory", "estimate", "free", "reach_10Nmm", "endoscope", "extensible_arm", "inserted", "pins",
                                  "sequence", "silicone_finger", "silicone_grasp", "tendon_arm", "tendon_lengths", "window"])
def test_plan(scenes, name):
    file = scenes / f"{name}.toml"
    # So that no search is cut by time on a busy machine.
    same(tendril.load(file).copy({"solver.time_limit": 100}).plan(), command("plan", file, "--set", "solver.time_limit=100"))


@pytest.mark.parametrize("name", ["brace", "grasp_60mm", "grasp_unequal", "trajectory"])
def test_verified_plan(scenes, name):
    file = scenes / f"{name}.toml"
    same(tendril.load(file).plan(verify=True), command("plan", file, "--verify"))


def test_settings(scenes, brace):
    brace["contact.max_force"] = "0.05 N"
    brace["rod.actuator[0].limit"] = 0.004
    brace["coordinates"] = {"plugin": "pcc", "pieces": 8, "split_at_contact": False}
    same(brace.plan(), command("plan", scenes / "brace.toml", "--set", "contact.max_force=0.05 N", "--set",
                               "rod.actuator.0.limit=0.004", "--set",
                               'coordinates={plugin="pcc",pieces=8,split_at_contact=false}'))


@pytest.mark.parametrize("name, changes", [
    ("brace", {"contact.friction": "0.3"}),
    ("grasp_60mm", {"contact.friction": "0.4"}),
    ("brace", {"rod.bending_stiffness": "4.9e-4 N m^2 +- 5 %", "obstacle[0].radius": "8 mm +- 0.2 mm"}),
])
def test_plan_with_friction_or_error_bars(scenes, name, changes):
    settings = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    same(tendril.load(scenes / f"{name}.toml").copy(changes).plan(), command("plan", scenes / f"{name}.toml", *settings))


MOVING = {"problem": "trajectory", "obstacle": [{"name": "peg", "shape": "circle", "center": ["60 mm", "0 mm"], "radius": "8 mm"}],
          "trajectory": {"obstacle": [{"name": "peg", "shifts": [["0 mm", "0 mm"], ["0 mm", "-1 mm"], ["1 mm", "-2 mm"]]}]}}


def test_moved_obstacles(brace, tmp_path):
    scene = brace.copy(MOVING)
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    moving = tendril.load(tmp_path / "scene.toml")
    path = moving.trajectory(verify=True)
    same(path, command("plan", tmp_path / "scene.toml", "--verify"))
    assert [step.moved_obstacles for step in path.steps][1:] == [{"peg": (0.0, -0.001, 0.0)}, {"peg": (0.001, -0.002, 0.0)}]
    path.save(tmp_path / "path.json")
    same(moving.execute(path), command("execute", tmp_path / "scene.toml", "--plan", tmp_path / "path.json"))


def test_execute_of_tendons(scenes):
    file = scenes / "tendon_arm.toml"
    count = len(tendril.load(file)["rod.actuator"])
    inputs = ["0.1 N"] * count
    same(tendril.load(file).execute(inputs=inputs), command("execute", file, "--inputs", ", ".join(inputs)))


def test_execute_of_a_tentacle_and_a_grasp(scenes, tmp_path):
    file = scenes / "tentacle.toml"
    same(tendril.load(file).execute([]), command("execute", file))
    grasp = scenes / "grasp_60mm.toml"
    plan = tendril.load(grasp).plan()
    plan.save(tmp_path / "grasp.json")
    same(tendril.load(grasp).execute(plan), command("execute", grasp, "--plan", tmp_path / "grasp.json"))


def test_execute_of_a_placed_rod(scenes):
    file = scenes / "inserted.toml"
    same(tendril.load(file).execute(["3 N mm"], insertion="150 mm", base=["2 mm", 0.0, "5 deg"]),
         command("execute", file, "--moments", "3 N mm", "--insertion", "150 mm", "--base", "2 mm, 0, 5 deg"))
    with pytest.raises(ValueError, match="insertion"):
        tendril.load(file).execute(["3 N mm"], insertion=float("nan"))


def test_execute_along_a_way(scenes, tmp_path):
    """Insertions, bases and moments one after the other, and what an earlier result holds, led elsewhere."""
    file = scenes / "inserted.toml"
    scene = tendril.load(file)
    plan = scene.plan()
    plan.save(tmp_path / "plan.json")
    held = tmp_path / "plan.json"
    same(scene.execute(plan=plan, insertion="170 mm"), command("execute", file, "--plan", held, "--insertion", "170 mm"))
    same(scene.execute(plan=plan, insertion=["190 mm", 0.17]), command("execute", file, "--plan", held, "--insertion", "190 mm; 0.17"))
    same(scene.execute(start=plan, insertion="190 mm; 170 mm"),
         command("execute", file, "--start", held, "--insertion", "190 mm; 170 mm"))
    same(scene.execute([["3 N mm"], ["2 N mm"]], base=[[0, 0, 0], ["1 mm", 0.0, "2 deg"]]),
         command("execute", file, "--moments", "3 N mm; 2 N mm", "--base", "0, 0, 0; 1 mm, 0, 2 deg"))
    way = scene.execute(plan=plan, insertion=np.linspace(plan["insertion"], 0.17, 3))
    assert [step["insertion"] for step in way.steps] == pytest.approx(np.linspace(plan["insertion"], 0.17, 3), abs=1e-12)
    assert way.steps[0].tip == pytest.approx(plan.tip, abs=1e-6)
    for options, why in (({"insertion": [0.1, 0.11, 0.12], "moments": [[0.0], [0.0]]}, "insertion|moments"),
                         ({"plan": way, "insertion": [0.1, 0.11]}, "^insertion: "), ({"base": [0, 0], "moments": [0]}, "^base: "),
                         ({"insertion": ["1 N"], "moments": [0]}, "^insertion: ")):
        with pytest.raises(tendril.Error, match=why):
            scene.execute(**options)


def test_execute(scenes, brace, tmp_path):
    file = scenes / "brace.toml"
    same(brace.execute(["2.5 N mm"]), command("execute", file, "--moments", "2.5 N mm"))
    same(brace.execute([0.0025]), command("execute", file, "--moments", "0.0025"))
    plan = brace.plan()
    plan.save(tmp_path / "plan.json")
    same(brace.execute(plan=plan), command("execute", file, "--plan", tmp_path / "plan.json"))
    same(brace.execute(0.001, start=plan),
         command("execute", file, "--moments", "0.001", "--start", tmp_path / "plan.json"))
    same(brace.execute([["2 N mm"], [0.0005]]), command("execute", file, "--moments", "2 N mm; 0.0005"))
    same(brace.execute("2 N mm; 0.0005"), command("execute", file, "--moments", "2 N mm; 0.0005"))
    snap = scenes / "snap_through.toml"
    same(tendril.load(snap).execute([-0.05]), command("execute", snap, "--moments", "-0.05"))


def test_execute_pressures_and_trajectories(scenes, tmp_path):
    grasp = scenes / "grasp_60mm.toml"
    same(tendril.load(grasp).copy({"gripper.palm_distance": "74 mm"}).execute(pressures=["30 kPa", 12000]),
         command("execute", grasp, "--set", "gripper.palm_distance=74 mm", "--pressures", "30 kPa, 12000"))
    scene = tendril.load(scenes / "trajectory.toml")
    planned = scene.trajectory()
    planned.save(tmp_path / "steps.json")
    same(scene.execute(planned), command("execute", scenes / "trajectory.toml", "--plan", tmp_path / "steps.json"))


def test_start(scenes, brace, tmp_path):
    plan = brace.plan()
    plan.save(tmp_path / "plan.json")
    expected = command("plan", scenes / "brace.toml", "--start", tmp_path / "plan.json")
    same(brace.plan(start=plan), expected)
    same(brace.plan(start=tmp_path / "plan.json"), expected)
    same(brace.plan(start=plan.to_dict()), expected)


@pytest.mark.parametrize("name", ["brace", "grasp_unequal", "estimate"])
def test_describe(scenes, name):
    file = scenes / f"{name}.toml"
    same(tendril.load(file).describe(), command("describe", file))


@pytest.mark.parametrize("options, arguments", [
    ({}, []), ({"held": True}, ["--held"]), ({"moments": ["2.4 N mm", ]}, ["--moments", "2.4 N mm"]),
])
def test_sensitivity(scenes, options, arguments):
    file = scenes / "brace.toml"
    same(tendril.load(file).sensitivity(**options), command("sensitivity", file, *arguments))
    same(tendril.load(file).sensitivity("rod.length", "gravity[1]", **options),
         command("sensitivity", file, "rod.length", "gravity[1]", *arguments))


def test_sensitivity_of_results(scenes, brace, tmp_path):
    file = scenes / "brace.toml"
    for result, arguments, options in ((brace.plan(), [], {}), (brace.plan(), ["--held"], {"held": True}), (brace.execute([2.4e-3]), [], {})):
        result.save(tmp_path / "result.json")
        same(result.sensitivities(**options), command("sensitivity", file, "--plan", tmp_path / "result.json", *arguments))


def test_sensitivity_of_a_step(scenes, tmp_path):
    file = scenes / "trajectory.toml"
    path = tendril.load(file).trajectory()
    path.save(tmp_path / "path.json")
    path.steps[6].save(tmp_path / "step.json")
    of_path = command("sensitivity", file, "--plan", tmp_path / "path.json", "--step", "7", "--held")
    same(path.steps[6].sensitivities(held=True), of_path)
    assert command("sensitivity", file, "--plan", tmp_path / "step.json", "--held")["numbers"] == of_path["numbers"]
    for words, why in (((), "which step"), (("--step", "46"), "step 46 among its 45"), (("--step", "0"), "step 0 among")):
        run = subprocess.run([command_path(), "sensitivity", file, "--plan", tmp_path / "path.json", *words], capture_output=True, text=True)
        assert run.returncode == 2 and why in run.stderr


def test_calibrate(scenes):
    file = scenes / "calibrate.toml"
    same(tendril.load(file).calibrate(), command("calibrate", file))


def test_study(scenes):
    file = scenes / "paradigms.toml"
    targets = '[["97 mm", "20 mm"]]'
    scene = tendril.load(file).copy({"study.targets": [["97 mm", "20 mm"]]})
    study = scene.study(jobs=2)
    same(study, command("study", file, "--set", f"study.targets={targets}"))
    assert len(study.table()) == len(study.cases) == 8


def test_study_of_a_text(scenes):
    scene = tendril.load(scenes / "paradigms.toml").copy({"study.targets": [["97 mm", "20 mm"]]})
    text = tendril.Scene(scene.to_dict())
    assert [c["moments"] for c in text.study().cases] == [c["moments"] for c in scene.study().cases]


def test_plugins():
    assert tendril.plugins() == command("plugins")


def test_module_is_the_command(scenes):
    for arguments in (["--version"], ["plan", str(scenes / "free.toml")], ["plan", "nosuch.toml"], ["wrong"]):
        one = subprocess.run([command_path(), *arguments], capture_output=True, text=True)
        other = subprocess.run([sys.executable, "-m", "tendril", *arguments], capture_output=True, text=True)
        assert (one.returncode, one.stderr) == (other.returncode, other.stderr)
    assert tendril.__version__ in subprocess.run([command_path(), "--version"], capture_output=True, text=True).stdout
