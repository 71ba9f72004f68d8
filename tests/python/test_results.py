"""Results: names, arrays, documents, pickles."""

import copy
import json
import pickle

import numpy as np
import pytest

import tendril


@pytest.fixture(scope="module")
def plan():
    from conftest import SCENES

    return tendril.load(SCENES / "brace.toml").plan()


def test_a_plan(plan):
    assert plan.solved and plan.status == "solved" and plan.message == ""
    assert plan.moments.shape == (1,) and plan.moments.dtype == float
    assert plan.backbone.shape[1] == 5 and plan.x[-1] == pytest.approx(plan.tip.x, rel=1e-12)
    assert plan.contacts[0].force == pytest.approx(0.078782, rel=1e-4)
    assert np.hypot(*plan.contacts[0].normal) == pytest.approx(1.0)
    assert plan.target_error == pytest.approx(np.hypot(plan.tip.x - 0.097, plan.tip.y - 0.02))
    assert sum(plan.terms.values()) == pytest.approx(plan.objective)
    assert plan["certificate"]["stability"] == plan.certificate["stability"]
    assert len(plan.coordinates) == plan["coordinates"]["dimension"]
    with pytest.raises(ValueError):
        plan.moments[0] = 1.0


def test_documents_and_pickles(plan, tmp_path):
    plan.save(tmp_path / "plan.json")
    for twin in (tendril.Plan.from_json(plan.to_json()), tendril.Plan.from_file(tmp_path / "plan.json"), tendril.Plan(plan.to_dict()),
                 pickle.loads(pickle.dumps(plan)), copy.deepcopy(plan)):
        assert twin == plan and type(twin) is tendril.Plan
        assert np.array_equal(twin.backbone, plan.backbone)
    assert json.loads(plan.to_json()) == plan.to_dict()


def test_html_and_repr(plan):
    assert "solved" in repr(plan) and "Brace on a peg" in repr(plan)
    sly = tendril.Plan({**plan.to_dict(), "title": "<script>"})
    assert "<script>" not in sly._repr_html_() and "&lt;script&gt;" in sly._repr_html_()


def test_tables_in_a_notebook(brace, scenes):
    """What stands in one line, and what has lines of its own."""
    rates = brace.sensitivity(held=True)
    assert "held" in repr(rates) and len(rates.table()) == len(rates["numbers"])
    assert rates.table()[0].keys() == {"number", "value", *rates.rows}
    calibration = tendril.load(scenes / "calibrate.toml").calibrate()
    assert calibration.row()["stiffness"] == calibration.found[0] and calibration.table()[0]["error"] == calibration.errors[0]
    study = tendril.load(scenes / "paradigms.toml").copy({"study.targets": [["97 mm", "20 mm"]]}).study()
    for result, lines in ((rates, rates.table()), (calibration, calibration.table()), (study, study.table())):
        html = result._repr_html_()
        assert html.count("<tr>") == len(lines) + 1 and html.count("<td") == len(lines) * html.count("<th")


def test_other_kinds(scenes):
    trajectory = tendril.load(scenes / "trajectory.toml").trajectory()
    assert trajectory.solved and trajectory.tips.shape == (45, 3) and trajectory.moments.shape[0] == 45
    assert trajectory.target_errors.max() == trajectory["target_error"]["largest"]
    estimate = tendril.load(scenes / "estimate.toml").estimate()
    assert estimate.covariance.shape == (2, 2) and estimate.contacts[0].force > 0.0
    sequence = tendril.load(scenes / "sequence.toml").estimate()
    assert isinstance(sequence, tendril.SequenceEstimate) and sequence.numbers == [1, 2, 3]
    assert sequence.times.shape == (48,) and sequence.forces.shape == sequence.arc_length_errors.shape == (48, 3)
    there = ~np.isnan(sequence.forces)
    assert there.sum(axis=1).max() == 1 and there[0, 0] and there[-1, 2]
    assert (sequence.force_errors[there] <= sequence.of_contacts("force_error", so_far=True)[there]).all()
    snapping = tendril.load(scenes / "snap_through.toml")
    execution = snapping.execute([-0.05], start=snapping.execute([0.1]))
    assert execution.load == 1.0 and execution.snaps
    description = tendril.load(scenes / "brace.toml").describe()
    assert description.variables["moments"] == 1 and description.rows["equilibrium"] == 12


def test_grasps_have_fingers(scenes):
    grasp = tendril.load(scenes / "grasp_unequal.toml").plan()
    upper, lower = grasp.fingers
    assert upper.backbone.shape == grasp.backbone.shape and upper.tip == grasp.tip and lower.tip.y < 0.0 < upper.tip.y
    assert upper.contacts + lower.contacts == grasp.contacts and {c.finger for c in grasp.contacts} == {"upper", "lower"}
    assert grasp.inputs.tolist() == grasp["pressures"] and grasp.inputs.dtype == float
    assert grasp.palm_distance == grasp["palm_distance"] > 0.0
    assert np.abs(grasp.net_force).max() < 1e-9 and grasp.net_force.shape == (2,)
    assert grasp.held_forces.shape == (0, 2) and grasp.friction_range == []


def test_friction_is_told(brace, scenes):
    plan = brace.copy({"contact.friction": 0.3}).plan()
    straight, *corners = plan.friction_range
    assert straight.ratios == (0.0,) and straight.tip == pytest.approx(plan.tip, abs=1e-6)
    assert sorted(corner.ratios[0] for corner in corners) == pytest.approx([-0.3, 0.3])
    for corner in corners:
        contact = corner.contacts[0]
        assert contact.tangential_force == pytest.approx(corner.ratios[0] * contact.force) and contact.state == "slip"
    held = tendril.load(scenes / "grasp_60mm.toml").copy({"contact.friction": 0.4}).plan().held_forces
    assert held.shape[1] == 2 and len(held) > 2 and held.dtype == float


def test_numbers_of_many_are_arrays(scenes):
    calibration = tendril.load(scenes / "calibrate.toml").calibrate()
    assert calibration.found.shape == calibration.errors.shape and calibration.covariance.shape == 2 * calibration.found.shape
    assert np.sqrt(np.diag(calibration.covariance)) == pytest.approx(calibration.errors)
    study = tendril.load(scenes / "paradigms.toml").copy({"study.targets": [["97 mm", "20 mm"]]}).study()
    assert study.of_cases("moments").shape == (8, 1) and study.of_cases("tip_error").shape == (8,)
    assert tendril.load(scenes / "silicone_finger.toml").plan().thickness.min() > 0.0


@pytest.mark.parametrize("text, why", [("{", "JSON"), ("[]", "dictionary"), ('{"schema": 2}', "schema"), ("{}", "schema"),
                                       ('{"schema": 1}', "status")])
def test_no_results(text, why):
    with pytest.raises((TypeError, ValueError), match=why):
        tendril.Plan.from_json(text)


@pytest.mark.parametrize("key, value, read", [
    ("backbone", [["a"]], lambda p: p.backbone), ("backbone", [[1, 2]], lambda p: p.backbone), ("tip", None, lambda p: p.tip),
    ("tip", {"x": 1}, lambda p: p.tip), ("contacts", "abc", lambda p: p.contacts), ("contacts", [{}], lambda p: p.contacts),
    ("moments", {}, lambda p: p.moments), ("backbone", [[1, 2], [3]], lambda p: p.backbone), ("inputs", [{"value": "a"}], lambda p: p.inputs),
])
def test_parts_of_another_version_are_named(plan, key, value, read):
    with pytest.raises(ValueError, match=f"^document: '{key}' is not as a result of this version has it: (?!document)"):
        read(tendril.Plan({**plan.to_dict(), key: value}))


def test_a_pickle_of_another_version_is_refused(plan):
    text = pickle.dumps(plan, protocol=0).replace(b'"schema": 1', b'"schema": 2')
    with pytest.raises(ValueError, match="schema 2"):
        pickle.loads(text)
    with pytest.raises(TypeError, match="text"):
        tendril.Plan.from_json(3)


def test_rows_are_plain_values(plan, scenes):
    others = [tendril.load(scenes / "trajectory.toml").trajectory(), tendril.load(scenes / "estimate.toml").estimate()]
    for result in (plan, *others, tendril.Failure({"message": "why"})):
        assert all(value is None or isinstance(value, (str, float, int)) for value in result.row().values())


def test_results_of_another_kind(plan, brace, scenes):
    with pytest.raises(ValueError, match="certificate"):
        tendril.Plan(tendril.load(scenes / "estimate.toml").estimate().to_dict())
    for value, kind in ((float("nan"), ValueError), (np.zeros(1), TypeError)):
        document = {**plan.to_dict(), "moments": value}
        with pytest.raises(kind, match="start: found what JSON cannot hold"):
            brace.plan(start=document)
        with pytest.raises(kind, match="document: found what JSON cannot hold"):
            tendril.Plan(document).to_json()
    with pytest.raises(ValueError, match="trajectory"):
        tendril.Trajectory(plan.to_dict())
    document = plan.to_dict()
    document["schema"] = 7
    with pytest.raises(tendril.Error, match="schema 7"):
        brace.plan(start=document)
    document = plan.to_dict()
    document["moments"] = []
    with pytest.raises(tendril.Error, match="moments"):
        brace.plan(start=document)
    with pytest.raises(tendril.Error, match="backbone"):
        brace.copy({"rod.length": "90 mm"}).plan(start=plan)
