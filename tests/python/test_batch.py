"""Many scenes in processes."""

import os
import subprocess
import sys

import pytest

import tendril


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_order_is_kept_and_failures_stay_alone(scenes, brace, method):
    heights = [0.0, 0.005, 0.01, 0.015, 0.02]
    many = [brace.copy({"target.position": [0.097, y]}) for y in heights]
    many.insert(2, brace.copy({"rod.lenght": 1}))
    seen = []
    results = tendril.plan_many(many, jobs=2, progress=lambda done, total: seen.append((done, total)), start_method=method)
    assert seen == [(i + 1, 6) for i in range(6)]
    assert isinstance(results[2], tendril.Failure) and "lenght" in results[2].message and not results[2].solved
    for y, result in zip(heights, results[:2] + results[3:]):
        assert result.moments == pytest.approx(brace.copy({"target.position": [0.097, y]}).plan().moments)
    rows = [result.row() for result in results]
    assert rows[0]["status"] == "solved" and rows[2]["status"] == "failed" and rows[0]["moment_0"] == results[0].moments[0]


CRASH = """
import os, sys, tendril
from tendril import _scene
plan = _scene.Scene.plan
def crashing(self, **options):
    if self["title"] == "crash":
        os.kill(os.getpid(), 11)
    if self["title"] == "memory":
        bytearray(1 << 34)
    return plan(self, **options)
_scene.Scene.plan = crashing
import resource
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
brace = tendril.load(sys.argv[1])
names = ["good", "crash", "good", "memory", "good", "crash", "good"]
results = tendril.plan_many([brace.copy(title=name) for name in names], jobs=2)
print([result.message or result.status for result in results])
"""


def test_a_process_that_dies_is_one_failure(scenes):
    run = subprocess.run([sys.executable, "-c", CRASH, str(scenes / "brace.toml")], capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stderr
    died = "its process was ended by signal 11"
    assert run.stdout.strip() == str(["solved", died, "solved", "out of memory", "solved", died, "solved"])


@pytest.mark.parametrize("there", [True, False])
def test_a_bar_needs_no_tqdm(brace, capsys, monkeypatch, there):
    if not there:
        monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    assert all(plan.solved for plan in tendril.plan_many([brace] * 3, jobs=2, progress=True))
    shown = capsys.readouterr().err
    assert ("3/3" if there else "3 of 3") in shown


def test_nothing_and_wrong_things(brace):
    assert tendril.plan_many([]) == []
    with pytest.raises(TypeError, match=r"scenes\[1\]"):
        tendril.plan_many([brace, "brace.toml"])
    for jobs in (0, 1.5, "2", True, float("inf")):
        with pytest.raises(ValueError, match="jobs"):
            tendril.plan_many([brace], jobs=jobs)
    with pytest.raises(TypeError, match="scenes"):
        tendril.plan_many(brace["title"])
    with pytest.raises(TypeError, match="progress"):
        tendril.plan_many([brace], progress=3)
    with pytest.raises(ValueError, match="start_method"):
        tendril.plan_many([brace], start_method="thread")


def test_an_exception_in_the_report_ends_the_processes(brace):
    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        tendril.plan_many([brace] * 10, jobs=2, progress=stop)
