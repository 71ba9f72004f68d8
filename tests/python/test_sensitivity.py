"""Derivatives, error bars and calibration from Python: what the command tells."""

import pickle

import numpy as np
import pytest

import tendril


def slope(values, step):
    """Of values at -2, -1, 1, 2 steps."""
    far_before, before, behind, far_behind = values
    return (8.0 * (behind - before) - (far_behind - far_before)) / (12.0 * step)


def test_the_jacobian_has_named_rows_and_columns(scenes):
    scene = tendril.load(scenes / "brace.toml")
    all_numbers = scene.sensitivity(held=True)
    assert all_numbers.held
    assert all_numbers.rows[:3] == ["tip.x", "tip.y", "tip.angle"]
    assert "obstacle[0].radius" in all_numbers.columns and "moments[0]" in all_numbers.columns
    assert all_numbers.matrix.shape == (len(all_numbers.rows), len(all_numbers.columns))
    column = all_numbers.matrix[:, all_numbers.columns.index("obstacle[0].radius")]
    assert list(all_numbers["obstacle[0].radius"].values()) == list(column)


def test_a_derivative_is_that_of_other_executions(scenes):
    scene = tendril.load(scenes / "brace.toml")
    plan = scene.plan()
    exact = plan.sensitivity("obstacle[0].radius", held=True)["tip.y"]
    tips = [scene.copy({"obstacle[0].radius": 8e-3 + side * 1e-5}).execute(plan.moments, start=plan).tip.y for side in (-2, -1, 1, 2)]
    assert exact == pytest.approx(slope(tips, 1e-5), rel=1e-6)


def test_an_execution_is_differentiated_under_its_own_moments(scenes):
    scene = tendril.load(scenes / "brace.toml")
    exact = scene.execute(["2.4 N mm"]).sensitivity("moments[0]")["tip.y"]
    tips = [scene.execute([2.4e-3 + side * 2e-6]).tip.y for side in (-2, -1, 1, 2)]
    assert exact == pytest.approx(slope(tips, 2e-6), rel=1e-6)


def test_the_state_at_hand_is_differentiated(scenes):
    """A rod that has snapped stays on its branch: the same moment from the scene's start leads elsewhere."""
    scene = tendril.load(scenes / "snap_through.toml")
    far = scene.execute([0.1])
    snapped, other = scene.execute([0.01], start=far), scene.execute([0.01], start=scene.execute([-0.1]))
    assert abs(snapped.tip.x - other.tip.x) > 0.01
    for start, state in ((far, snapped), (scene.execute([-0.1]), other)):
        tips = [scene.execute([0.01 + side * 1e-5], start=start).tip.x for side in (-2, -1, 1, 2)]
        assert state.sensitivity("moments[0]")["tip.x"] == pytest.approx(slope(tips, 1e-5), rel=1e-6)


def test_nothing_is_planned_for_the_derivatives_of_a_plan(scenes, tmp_path):
    scene = tendril.load(scenes / "brace.toml")
    plan = scene.plan()
    plan.save(tmp_path / "plan.json")
    for held in (False, True):
        known = plan.sensitivities(held=held)
        assert known == scene.sensitivity(held=held) == scene.sensitivity(held=held, plan=tmp_path / "plan.json")
        [there] = tendril.plan_many([scene])
        assert there.sensitivities(held=held) == pickle.loads(pickle.dumps(plan)).sensitivities(held=held) == known
    executed = scene.execute(plan.moments)
    assert executed.sensitivities() == scene.sensitivity(moments=plan.moments) == scene.sensitivity(plan=executed)
    stiffer = scene.copy({"rod.bending_stiffness": "6e-4 N m^2"})
    for result, held, why in ((plan, False, "no isolated optimum"), (plan, True, "no equilibrium of this scene"),
                              (executed, True, "no solution next to it")):
        with pytest.raises(ValueError, match=why):
            stiffer.sensitivity("rod.length", held=held, plan=result)
    with pytest.raises(ValueError, match="plan: "):
        scene.sensitivity(plan=plan, moments=[1e-3])
    with pytest.raises(tendril.Error, match="status"):
        scene.sensitivity(plan={**plan.to_dict(), "status": 3})


def test_steps_of_a_trajectory_have_derivatives(scenes, tmp_path):
    """Those of the pose of the step, planned anew or under its held moments; a target is a number of it. Obstacles are where the
    step has them, and their place has no derivatives there."""
    scene = tendril.load(scenes / "trajectory.toml").copy({"trajectory": {"positions": [[0.0986, 0.009], [0.0984, 0.0105]]}})
    shifts = {"trajectory.obstacle": [{"name": "obstacle 1", "shifts": [[0.0, 0.0], [0.001, -0.001]]}]}
    for scene, centre in ((scene, [0.06, 0.0]), (scene.copy(shifts), [0.061, -0.001])):
        trajectory = scene.trajectory()
        pose = tendril.load(scenes / "trajectory.toml").copy({"problem": "pose", "obstacle[0].center": centre, "target.position": [0.0984, 0.0105]})
        del pose["trajectory"]
        plan = pose.plan(start=trajectory.steps[1])
        for held in (False, True):
            keys = ["obstacle[0].radius", *["target.position[1]"] * (not held), *["obstacle[0].center[1]"] * (centre[0] == 0.06)]
            for key in keys:
                found = trajectory.steps[1].sensitivity(key, held=held)
                assert found == pytest.approx(plan.sensitivity(key, held=held), rel=1e-6, abs=1e-7)
        # The same of a file, of a pickle, and of steps that were carried out.
        trajectory.steps[1].save(tmp_path / "step.json")
        everything = trajectory.steps[1].sensitivities(held=True)
        assert scene.sensitivity(plan=tmp_path / "step.json", held=True) == everything
        assert pickle.loads(pickle.dumps(trajectory)).steps[1].sensitivities(held=True) == everything
        executed = scene.execute(trajectory).steps[1].sensitivities()
        assert executed.held and executed["moments[0]"] == pytest.approx(everything["moments[0]"], rel=1e-3)
    with pytest.raises(ValueError, match="an obstacle that was moved"):
        trajectory.steps[1].sensitivity("obstacle[0].center[1]")
    with pytest.raises(tendril.Error, match="steps"):
        scene.sensitivity(plan=trajectory)
    with pytest.raises(tendril.Error, match="a step of an earlier result"):
        scene.sensitivity()


def test_derivatives_of_the_plan_are_those_of_other_plans(scenes):
    """The Jacobian of the planned moment and tip, with a term of this process, against plans of scenes on either side."""

    @tendril.objective("own_term", reads=["tip_angle"])
    def own_term(x):
        return [x.tip.angle - 0.3]

    scene = tendril.load(scenes / "brace.toml").copy({"solver": {"plugin": "ipopt"}})
    scene = scene.copy({"objective": [*scene["objective"], {"plugin": "own_term", "weight": 0.1}]})
    keys = {"obstacle[0].radius": 8e-3, "rod.bending_stiffness": 4.9e-4, "target.position[1]": 0.02}
    try:
        exact = scene.sensitivity(*keys)
        for key, value in keys.items():
            step = 1e-3 * value
            either = [scene.copy({key: value + side * step}).plan() for side in (-2, -1, 1, 2)]
            for quantity, of in (("tip.y", lambda p: p.tip.y), ("tip.angle", lambda p: p.tip.angle), ("moments[0]", lambda p: p.moments[0])):
                difference = slope(list(map(of, either)), step)
                assert exact[key][quantity] == pytest.approx(difference, rel=1e-6, abs=1e-6 * abs(of(either[0]) / value))
    finally:
        tendril.unregister("own_term")


def test_given_moments_are_held(scenes):
    scene = tendril.load(scenes / "brace.toml")
    assert scene.sensitivity("moments[0]", moments=["2.4 N mm"])["moments[0]"] == scene.execute([2.4e-3]).sensitivity("moments[0]")
    for moments, kind in (([float("nan")], ValueError), ([None], TypeError), (["3 kg"], tendril.Error), ([1.0, 2.0], tendril.Error)):
        with pytest.raises(kind, match="moments"):
            scene.sensitivity(moments=moments)
    with pytest.raises(ValueError, match="held"):
        scene.sensitivity(moments=[1e-3], held=True)


def test_error_bars_are_in_results(scenes):
    scene = tendril.load(scenes / "brace.toml").copy({"rod.bending_stiffness": "4.9e-4 N m^2 +- 5 %"})
    plan = scene.plan()
    assert plan.uncertainty["kind"] == "held"
    assert plan.uncertainty["shares"] == {"rod.bending_stiffness": 1.0}
    rate = scene.sensitivity("rod.bending_stiffness", held=True)["rod.bending_stiffness"]
    assert plan.uncertainty["tip"]["y"] == pytest.approx(abs(rate["tip.y"]) * 0.05 * 4.9e-4, rel=1e-9)
    executed = scene.execute(plan.moments)
    assert executed.uncertainty["tip"]["y"] == pytest.approx(plan.uncertainty["tip"]["y"], rel=1e-3)
    assert tendril.load(scenes / "brace.toml").plan().uncertainty is None


def test_what_has_no_derivative_says_why(scenes):
    scene = tendril.load(scenes / "brace.toml")
    with pytest.raises(tendril.Error, match="did you mean 'rod.length'"):
        scene.sensitivity("rod.lenght")
    with pytest.raises(TypeError, match="expected the path of a number"):
        scene.sensitivity(3)
    with pytest.raises(TypeError, match="does not know its scene"):
        tendril.Plan.from_json(scene.plan().to_json()).sensitivity("rod.length")


def test_sensitivities_are_pickled(scenes):
    some = tendril.load(scenes / "brace.toml").sensitivity("rod.length")
    assert np.array_equal(pickle.loads(pickle.dumps(some)).matrix, some.matrix)


def test_calibration(scenes, tmp_path):
    with pytest.raises(tendril.Error, match="calibrate.xyz"):
        tendril.load(scenes / "calibrate.toml").calibrate(figure=tmp_path / "calibrate.xyz")
    with pytest.raises(TypeError, match="output"):
        tendril.load(scenes / "calibrate.toml").calibrate(output=3)
    calibration = tendril.load(scenes / "calibrate.toml").calibrate(output=tmp_path, figure=tmp_path / "own.svg")
    assert tendril.Calibration.from_file(tmp_path / "result.json")["numbers"] == calibration["numbers"]
    assert {"own.svg", "figure.svg", "rod.toml"} <= {file.name for file in tmp_path.iterdir()}
    assert calibration.identifiable
    assert all(number["error"] > 0 for number in calibration.numbers)
