"""Scenes: keys, values with units, copies, messages with places."""

import copy
import pickle

import numpy as np
import pytest

import tendril

TABLES = {
    "gravity": [0, -9.81],
    "rod": {"length": "100 mm", "bending_stiffness": 4.9e-4, "linear_density": "84 g/m", "actuator": [{"limit": "2.5 N mm"}]},
    "start": {"tip_angle": 0.5},
    "obstacle": [{"shape": "circle", "center": ["60 mm", 0.0], "radius": "8 mm"}],
    "target": {"position": ["97 mm", "20 mm"]},
    "objective": [{"plugin": "tip_pose", "weight": 100}, {"plugin": "actuation_effort", "weight": 1e-4}],
}


def test_a_scene_of_tables_is_the_scene_of_the_file(brace):
    plan = tendril.Scene(TABLES).plan()
    assert plan.solved
    assert plan.moments == pytest.approx(brace.plan().moments, rel=1e-9)
    assert tendril.Scene(**TABLES) == tendril.Scene(TABLES)


def test_keys(brace):
    assert brace["contact.max_force"] == "1 N"
    assert brace["obstacle[0].radius"] == brace["obstacle.0.radius"] == "8 mm"
    assert "target.position" in brace and "target.turns" not in brace
    assert list(brace)[:2] == ["title", "problem"]
    brace["contact.max_force"] = "2 N"
    assert brace["contact.max_force"] == "2 N"
    del brace["contact"]
    assert "contact" not in brace and brace.plan().solved
    with pytest.raises(KeyError, match="contact.max_force"):
        brace["contact.max_force"]
    with pytest.raises(KeyError):
        del brace["obstacle[3]"]


def test_a_notebook_completes_keys(brace):
    offered = brace._ipython_key_completions_()
    assert {"title", "rod.length", "rod.actuator", "rod.actuator[0].limit", "obstacle[0].center", "target.position"} <= set(offered)
    assert all(key in brace for key in offered)
    assert "certificate" in brace.plan()._ipython_key_completions_()


def test_text_comes_back(brace):
    again = tendril.Scene.from_toml(brace.to_toml())
    assert again == brace and again.to_toml() == brace.to_toml()
    odd = tendril.Scene({"title": 'a "quoted" \\ text\n\twith é \x01', "rod": {"length": 1.0, "odd key": [1, 2.5, True]}})
    assert odd["title"] == 'a "quoted" \\ text\n\twith é \x01'
    assert odd["rod"] == {"length": 1.0, "odd key": [1, 2.5, True]}
    assert tendril.Scene.from_toml(odd.to_toml()) == odd


def test_copies_are_apart(brace):
    other = brace.copy(contact={"max_force": "2 N"}, title="other")
    assert brace["contact.max_force"] == "1 N" and other["contact.max_force"] == "2 N"
    assert other["contact.mode"] == "allow"
    assert brace.copy({"obstacle[0].radius": 0.004})["obstacle[0].radius"] == 0.004
    for twin in (copy.copy(other), copy.deepcopy(other), pickle.loads(pickle.dumps(other))):
        assert twin == other
        twin["title"] = "twin"
        assert other["title"] == "other"


def test_quantities(brace):
    expected = brace.plan().tip
    for radius in (0.008, "8 mm", "0.8 cm", np.float64(0.008)):
        assert brace.copy({"obstacle[0].radius": radius}).plan().tip == expected
    for center in (["60 mm", "0 mm"], (0.06, 0), np.array([0.06, 0.0])):
        assert brace.copy({"obstacle[0].center": center}).plan().tip == expected
    assert brace.copy({"coordinates.order": np.int64(6)}).plan().tip == expected


def test_quantities_of_pint(brace):
    import pint

    unit = pint.UnitRegistry()
    limit = brace.copy({"contact.max_force": 50 * unit.millinewton}).plan()
    assert limit.tip == brace.copy({"contact.max_force": 0.05}).plan().tip
    moved = brace.copy({"obstacle[0].center": np.array([61.0, 1.0]) * unit.mm}).plan()
    assert moved.tip == pytest.approx(brace.copy({"obstacle[0].center": [0.061, 0.001]}).plan().tip, rel=1e-9)
    assert brace.execute([2.5 * unit.N * unit.mm]).tip == pytest.approx(brace.execute([0.0025]).tip, rel=1e-9)
    with pytest.raises(tendril.Error, match="obstacle.*radius.*length"):
        brace.copy({"obstacle[0].radius": 8 * unit.kg}).plan()


def test_messages_name_the_place(tmp_path):
    file = tmp_path / "wrong.toml"
    file.write_text("[rod]\nlength = \"100 mm\"\nbending_stifness = 1\n")
    with pytest.raises(tendril.Error) as caught:
        tendril.load(file)
    error = caught.value
    assert (error.file, error.line, error.column, error.suggestion) == (str(file), 3, 1, "bending_stiffness")
    assert isinstance(error, ValueError)
    with pytest.raises(tendril.Error) as caught:
        tendril.Scene({**TABLES, "rod": {**TABLES["rod"], "length": "3 kg"}}).plan()
    line = tendril.Scene({**TABLES, "rod": {**TABLES["rod"], "length": "3 kg"}}).to_toml().splitlines()[caught.value.line - 1]
    assert line == 'length = "3 kg"'


def test_messages_name_the_setting(brace):
    brace["contact.max_forse"] = "2 N"
    with pytest.raises(tendril.Error, match='scene."contact.max_forse".*max_force') as caught:
        brace.plan()
    assert caught.value.suggestion == "max_force" and caught.value.line is None


def test_warnings(brace):
    with pytest.warns(UserWarning, match="did you mean .* deg"):
        brace.copy({"start.tip_angle": 30}).describe()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), None, object(), 1j, {1: 2}, [[None]], b"8 mm"])
def test_values_that_are_none(brace, value):
    with pytest.raises((TypeError, ValueError), match=r"obstacle\[0\].radius"):
        brace["obstacle[0].radius"] = value
    assert brace["obstacle[0].radius"] == "8 mm"


@pytest.mark.parametrize("moments, why", [
    ([], "0 moments"), (np.zeros((0, 1)), "0 moments"), (np.zeros((2, 1, 1)), r"moments\[0\]\[0\]"), ({1e-3}, "moments"),
    ({"a": 1}, "schema"), (b"1", "moments"), ([True], r"moments\[0\]"), ("", "0 moments"), ([[]], "0 moments"),
])
def test_moments_of_other_shapes(brace, moments, why):
    with pytest.raises((TypeError, ValueError), match=why):
        brace.execute(moments)


def test_messages_name_arguments_and_no_options(brace, scenes):
    for call in (lambda: brace.execute(pressures=[1e3]), lambda: brace.execute([1e-3], base=[0, 0]),
                 lambda: brace.execute(["1 kPa"]), lambda: brace.execute(inputs=["1 kPa"]),
                 lambda: tendril.load(scenes / "tendon_arm.toml").execute([1e-3] * 4)):
        with pytest.raises(tendril.Error) as caught:
            call()
        assert "--" not in str(caught.value)


def test_text_that_is_no_unicode(brace, tmp_path):
    bad = "a\ud800"
    for call in (lambda: brace.copy({"title": bad}), lambda: brace.copy({bad: 1}), lambda: brace.copy({"rod": {bad: 1}}),
                 lambda: tendril.Scene(title=bad), lambda: tendril.Scene.from_toml(bad), lambda: brace.execute([bad]),
                 lambda: brace.plan(start={"schema": bad}), lambda: brace.execute(insertion=bad),
                 lambda: brace.plan().view(tmp_path / bad), lambda: brace.sensitivity(bad), lambda: tendril.load(bad),
                 lambda: brace.problem().follow((bad, 0)), lambda: brace["obstacle"] + brace[bad], lambda: tendril.command(bad)):
        with pytest.raises((ValueError, KeyError, OSError)) as caught:
            call()
        assert "incompatible" not in str(caught.value)
    assert bad not in brace


def test_lists_without_end(brace):
    value = []
    value.append(value)
    with pytest.raises(ValueError, match="rod"):
        brace["rod"] = value


def test_wrong_calls(brace, tmp_path):
    with pytest.raises(TypeError):
        brace[3]
    with pytest.raises(KeyError):
        brace[""] = 1
    with pytest.raises(tendril.Error, match="nosuch"):
        brace["obstacle[7].nosuch"] = 1
    with pytest.raises(FileNotFoundError):
        tendril.load(tmp_path / "nosuch.toml")
    with pytest.raises(TypeError, match="file"):
        tendril.load(3.5)
    for directories in ("plugins", 3, [3]):
        with pytest.raises(TypeError, match="plugin_directories"):
            tendril.Scene(TABLES, plugin_directories=directories)
    with pytest.raises(TypeError, match="tables"):
        tendril.Scene(3)
    with pytest.raises(TypeError, match="changes"):
        brace.copy(3)
    (tmp_path / "bytes.toml").write_bytes(b"title = '\xff'")
    with pytest.raises(ValueError, match="UTF-8"):
        tendril.load(tmp_path / "bytes.toml")
    with pytest.raises(tendril.Error):
        tendril.Scene.from_toml("title = \"a\0b\"").plan()
    with pytest.raises(TypeError, match="text"):
        tendril.Scene.from_toml(3)
    with pytest.raises(TypeError, match="moments and pressures"):
        brace.execute([1], pressures=[1])
    with pytest.raises(TypeError, match=r"moments\[0\]"):
        brace.execute([None])
    with pytest.raises(ValueError, match=r"moments\[0\]"):
        brace.execute([float("nan")])
    with pytest.raises(tendril.Error, match="actuators"):
        brace.execute([1.0, 2.0])
    with pytest.raises(tendril.Error, match="actuators"):
        brace.execute()
    with pytest.raises(TypeError, match="start"):
        brace.plan(start=3)
    with pytest.raises(ValueError, match="problem"):
        brace.trajectory()
    with pytest.raises(tendril.Error, match="study"):
        brace.study()
    with pytest.raises(ValueError, match="jobs"):
        brace.study(jobs=0)


def test_files_are_looked_for_beside_the_scene(scenes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert tendril.load(scenes / "estimate.toml").estimate().solved
