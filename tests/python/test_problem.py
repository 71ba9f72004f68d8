"""Loops, threads, interrupts, many plans."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import tendril


def test_follow_plans_what_plan_plans(brace):
    problem = brace.problem()
    problem.follow((0.097, 0.02))
    plan = brace.plan()
    assert problem.solved and problem.status == "solved"
    assert problem.moments == pytest.approx(plan.moments, rel=1e-9)
    assert problem.backbone.shape == plan.backbone.shape
    for y in np.linspace(0.02, 0.018, 11):
        problem.follow(["97 mm", y])
        assert problem.solved
    there = brace.copy({"target.position": [0.097, 0.018]}).plan()
    assert problem.moments == pytest.approx(there.moments, rel=1e-6)
    assert problem.contacts[0]["force"] == pytest.approx(there.contacts[0].force, rel=1e-6)
    assert problem.result().tip == pytest.approx(problem.tip)
    assert problem.target_error == problem.result().target_error


def test_what_newton_does_not_reach_is_planned(brace):
    """Targets that another set of active limits and contacts reaches."""
    problem = brace.problem()
    for target in ((0.097, 0.02), (0.097, 0.0), (0.06, 0.07)):
        problem.follow(target)
        there = brace.copy({"target.position": target}).plan()
        assert problem.solved and problem.objective == pytest.approx(there.objective, rel=1e-9)


def test_interrupts_come_between_steps(brace):
    problem = brace.problem()
    problem.follow((0.097, 0.02))
    threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1_000_000):
            problem.follow((0.097, 0.02))
    problem.follow((0.097, 0.019))
    assert problem.solved


def test_arrays_outlive_the_step_and_the_problem(brace):
    problem = brace.problem()
    problem.follow((0.097, 0.02))
    moments, shape = problem.moments, problem.backbone
    before = moments.copy(), shape.copy()
    problem.follow((0.097, 0.0))
    del problem
    gc.collect()
    assert np.array_equal(moments, before[0]) and np.array_equal(shape, before[1])


@pytest.mark.parametrize("arguments, why", [
    (((1.0,),), "position"), ((3.0,), "position"), (("ab",), "position"), (((float("nan"), 0.0),), r"position\[0\]"),
    (((0.1, None),), r"position\[1\]"), ((("3 kg", 0.0),), r"position\[0\]"), ((), "target"), ((None, float("inf")), "angle"),
    ((np.zeros((2, 2)),), r"position\[0\]"), (((0.097, 0.02), 0.1, 1.5), "turns"), (((0.097, 0.02), 0.1, "one"), "turns"),
    (((0.097, 0.02), 0.1, 10**30), "turns"), (((0.097, 0.02), 0.1, True), "turns"),
])
def test_bad_targets(brace, arguments, why):
    problem = brace.problem()
    with pytest.raises((TypeError, ValueError), match=why):
        problem.follow(*arguments)
    problem.follow((0.097, 0.02))
    problem.follow((0.097, 0.02), 0.1, 0.0)  # a whole number, too
    assert problem.solved


def test_threads_plan_at_the_same_time(brace):
    expected = brace.plan().moments
    problem = brace.problem()
    found = []

    def work():
        found.append(brace.plan().moments[0])
        problem.follow((0.097, 0.02))

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected[0]] * 8
    assert problem.moments == pytest.approx(expected, rel=1e-6)


INTERRUPTED = """
import os, signal, threading, time, tendril
scene = tendril.load({scene!r}).copy({{"search.effort": "thorough", "solver.time_limit": 60}})
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
begin = time.monotonic()
try:
    scene.{call}
except KeyboardInterrupt:
    print("interrupted after", time.monotonic() - begin)
assert tendril.load({brace!r}).plan().solved
"""


@pytest.mark.parametrize("call", ["plan()", "problem().plan()", "problem().follow((0.1, 0.05))", "sensitivity()"])
def test_control_c(scenes, call):
    text = INTERRUPTED.format(scene=str(scenes / "clutter.toml"), brace=str(scenes / "brace.toml"), call=call)
    run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("interrupted after 0.") or run.stdout.startswith("interrupted after 1."), run.stdout


def test_a_handler_of_the_user_is_called(scenes):
    heard = []
    before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    try:
        scene = tendril.load(scenes / "clutter.toml").copy({"search.effort": "thorough", "solver.time_limit": 60})
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        plan = scene.plan()
        assert heard == [signal.SIGINT] and plan.status in ("interrupted", "solved")
        assert signal.getsignal(signal.SIGINT) is not before
    finally:
        signal.signal(signal.SIGINT, before)


def test_import_takes_no_numpy():
    text = "import sys, tendril; assert 'numpy' not in sys.modules and 'matplotlib' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", text]).returncode == 0


def test_progress_is_told(brace, scenes):
    seen = []
    plan = brace.plan(progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, 0) for i in range(len(seen))] and len(seen) > sum(mode["solves"] for mode in plan["modes"])
    way = tendril.load(scenes / "trajectory.toml").copy({"trajectory": {"positions": [[0.09, 0.03], [0.091, 0.03], [0.092, 0.03]]}})
    seen.clear()
    assert len(way.trajectory(progress=lambda done, total: seen.append((done, total))).steps) == 3
    assert seen == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("there", [True, False])
def test_a_bar_of_a_trajectory(scenes, capsys, monkeypatch, there):
    if not there:
        monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    way = tendril.load(scenes / "trajectory.toml").copy({"trajectory": {"positions": [[0.09, 0.03], [0.091, 0.03]]}})
    way.trajectory(progress=True)
    assert ("2/2" if there else "2 of 2") in capsys.readouterr().err


def test_what_is_raised_in_the_report_ends_the_plan(brace, scenes):
    def enough(done, total):
        seen.append(done)
        raise RuntimeError("enough")

    for scene in (brace, tendril.load(scenes / "trajectory.toml"), tendril.load(scenes / "grasp_unequal.toml")):
        seen = []
        with pytest.raises(RuntimeError, match="enough"):
            scene.plan(progress=enough)
        assert seen == [1]
    found = []

    def work():
        with pytest.raises(RuntimeError, match="enough"):
            brace.plan(progress=enough)
        found.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [True] and brace.plan().solved
    for progress in (None, 3, "bar"):
        with pytest.raises(TypeError, match="progress"):
            brace.plan(progress=progress)
