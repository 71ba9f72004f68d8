"""Derivatives, error bars and calibration from Python: what the command tells."""

import pickle

import numpy as np
import pytest

import tendril


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
    step = 1e-5
    tips = [scene.copy({"obstacle[0].radius": 8e-3 + side * step}).execute(plan.moments, start=plan).tip.y
            for side in (-1, 1)]
    assert exact == pytest.approx((tips[1] - tips[0]) / (2 * step), rel=1e-4)


def test_an_execution_is_differentiated_under_its_own_moments(scenes):
    scene = tendril.load(scenes / "brace.toml")
    exact = scene.execute(["2.4 N mm"]).sensitivity("moments[0]")["tip.y"]
    step = 1e-7
    tips = [scene.execute([2.4e-3 + side * step]).tip.y for side in (-1, 1)]
    assert exact == pytest.approx((tips[1] - tips[0]) / (2 * step), rel=1e-4)
    with pytest.raises(TypeError, match="from another start"):
        scene.execute(["2.4 N mm"], start=scene.plan()).sensitivity("moments[0]")


def test_components_of_this_process_are_refused(scenes):
    scene = tendril.load(scenes / "brace.toml")
    tendril.objective("own_term", reads=["tip_angle"])(lambda x: [x.tip.angle])
    try:
        with pytest.raises(ValueError, match="sensitivity: the scene names objective 'own_term' of this process"):
            scene.copy({"objective": [{"plugin": "own_term"}]}).sensitivity("rod.length")
    finally:
        tendril.unregister("own_term")


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


def test_calibration(scenes):
    calibration = tendril.load(scenes / "calibrate.toml").calibrate()
    assert calibration.identifiable
    assert all(number["error"] > 0 for number in calibration.numbers)
