"""Studies: here, in processes, in parts, interrupted, and with components that only this process knows."""

import json
import os
import subprocess
import sys

import pytest

import tendril
from tendril._command import command_path


@pytest.fixture
def sweep(scenes):
    return tendril.load(scenes / "paradigms.toml").copy({"study.targets": [["97 mm", "20 mm"]]})


@pytest.fixture
def own_sweep(sweep):
    """The same with a term of this process in the place of the plugin that it is equal to."""

    @tendril.objective("to_target", reads=["tip_position", "target"])
    def to_target(x):
        return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

    terms = sweep["objective"]
    yield sweep.copy({"objective": [{**terms[0], "plugin": "to_target"}, *terms[1:]]})
    tendril.unregister("to_target")


def without_times(study):
    return {key: value for key, value in study.to_dict().items() if key not in ("seconds", "scene")}


def test_processes_give_what_this_one_gives(own_sweep):
    here = own_sweep.study()
    assert here.solved and len(here.cases) == 8
    seen = []
    apart = own_sweep.study(jobs=2, progress=lambda done, total: seen.append((done, total)))
    assert without_times(apart) == without_times(here)
    assert seen == [(i + 1, 8) for i in range(8)]


def test_a_term_of_this_process_studies_what_the_plugin_studies(sweep, own_sweep):
    for own, plugin in zip(own_sweep.study().cases, sweep.study().cases, strict=True):
        assert own["status"] == plugin["status"]
        assert own["moments"] == pytest.approx(plugin["moments"], rel=1e-5)


def test_an_unfinished_study_goes_on_in_either_program(sweep, scenes, tmp_path):
    def enough(done, total):
        if done == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sweep.study(output=tmp_path / "a", progress=enough)
    run = subprocess.run([command_path(), "study", scenes / "paradigms.toml", "--json", "--output", tmp_path / "a", "--set",
                          'study.targets=[["97 mm", "20 mm"]]'], capture_output=True, text=True)
    assert "3 of 8 cases are there already; 5 to go" in run.stderr
    seen = []
    again = sweep.study(output=tmp_path / "a", progress=lambda done, total: seen.append(done))
    assert seen == [] and without_times(again) == without_times(sweep.study())
    assert json.loads(run.stdout) == again.to_dict()
    assert {"study.json", "cases.csv", "groups.csv", "table.txt"} <= {file.name for file in (tmp_path / "a").iterdir()}


def test_parts_are_joined(sweep, tmp_path):
    assert sweep.study(output=tmp_path, shard=(1, 2)) is None
    with pytest.raises(tendril.Error, match="shard 2 of 2: .* is missing"):
        sweep.study(output=tmp_path, merge=True)
    assert sweep.study(output=tmp_path, shard=(2, 2), jobs=2) is None
    assert without_times(sweep.study(output=tmp_path, merge=True, figure=tmp_path / "joined.svg")) == without_times(sweep.study())
    assert (tmp_path / "joined.svg").read_text().startswith("<?xml")


def test_a_case_whose_process_dies_is_a_failed_case(own_sweep):
    here = os.getpid()

    @tendril.objective("dies", reads=["moments"])
    def dies(x):
        if os.getpid() != here and x.moments[0] > 4e-3 / (4.9e-4 / 0.1):  # as planned for one case alone
            os._exit(7)
        return [0.0 * x.moments[0]]

    try:
        study = own_sweep.copy({"objective": [*own_sweep["objective"], {"plugin": "dies"}]}).study(jobs=2)
    finally:
        tendril.unregister("dies")
    states = {(case["mode"], case["status"]) for case in study.cases}
    assert ("allow", "solved") in states and ("avoid", "failed") in states
    assert {case["message"] for case in study.cases if case["status"] == "failed"} == {"its process was ended with exit code 7"}
    assert not study.solved


INTERRUPTED = """
import os, signal, sys, tendril
count = []
@tendril.objective("told", reads=["tip_position"])
def told(x):
    count.append(1)
    if len(count) == 400:
        os.kill(os.getpid(), signal.SIGINT)
    return [x.tip.x - 0.97]
scene = tendril.load(sys.argv[1])
scene = scene.copy({"objective": [*scene["objective"], {"plugin": "told", "weight": 1e-9}]})
done = []
try:
    scene.study(output=sys.argv[2], progress=lambda finished, total: done.append(finished))
except KeyboardInterrupt:
    print("interrupted", len(done))
lines = open(sys.argv[2] + "/shard-1-of-1.journal").read().splitlines()
print("kept", len(lines) - 1, "interrupted" in "".join(lines))
"""


def test_control_c_keeps_what_is_finished(scenes, tmp_path):
    run = subprocess.run([sys.executable, "-c", INTERRUPTED, scenes / "paradigms.toml", tmp_path / "s"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    interrupted, kept = run.stdout.splitlines()
    assert interrupted.split()[0] == "interrupted" and int(interrupted.split()[1]) < 200
    assert kept == f"kept {interrupted.split()[1]} False"


SPAWNED = """
import sys, tendril

@tendril.objective("to_target", reads=["tip_position", "target"])
def to_target(x):
    return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

if __name__ == "__main__":
    scene = tendril.load(sys.argv[1]).copy({"study.targets": [["97 mm", "20 mm"]]})
    terms = scene["objective"]
    scene = scene.copy({"objective": [{**terms[0], "plugin": "to_target"}, *terms[1:]]})
    pose = tendril.load(sys.argv[2])
    pose = pose.copy({"objective": [{**pose["objective"][0], "plugin": "to_target"}]})
    for method in ("fork", "spawn"):
        print(scene.study(jobs=2, start_method=method).solved, tendril.plan_many([pose] * 2, jobs=2, start_method=method)[1].solved)
"""


def test_processes_of_either_kind_know_the_components_of_a_script(scenes, tmp_path):
    (tmp_path / "script.py").write_text(SPAWNED)
    run = subprocess.run([sys.executable, tmp_path / "script.py", scenes / "paradigms.toml", scenes / "brace.toml"],
                         capture_output=True, text=True)
    assert run.stdout == "True True\nTrue True\n", run.stderr


@pytest.mark.parametrize("arguments, kind, why", [
    ({"jobs": 0}, ValueError, "jobs"), ({"jobs": "2"}, ValueError, "jobs"), ({"jobs": True}, ValueError, "jobs"),
    ({"shard": 3}, TypeError, "shard"), ({"shard": (0, 2)}, ValueError, r"shard\[0\]"), ({"shard": (1, 2)}, tendril.Error, "output"),
    ({"shard": (3, 2), "output": "x"}, tendril.Error, "3/2"), ({"merge": True}, tendril.Error, "output"),
    ({"progress": 3}, TypeError, "progress"), ({"output": 3}, TypeError, "output"), ({"figure": 3}, TypeError, "figure"),
    ({"figure": "x.xyz"}, tendril.Error, "x.xyz"), ({"movie": "x.svg"}, tendril.Error, "x.svg"),
    ({"output": "/proc/nothing"}, tendril.Error, "/proc/nothing"),
    ({"jobs": 2, "start_method": "x"}, ValueError, "start_method"),
])
def test_wrong_arguments(sweep, arguments, kind, why, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind, match=why):
        sweep.study(**arguments)
    assert list(tmp_path.iterdir()) == []
