"""Pictures: what is drawn, and files that are what their names say."""

import numpy as np
import pytest

import tendril

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")


@pytest.mark.parametrize("name", ["brace", "ledge", "table", "grasp_60mm", "grasp_unequal"])
def test_plot(scenes, name):
    plan = tendril.load(scenes / f"{name}.toml").plan()
    ax = plan.plot()
    rods = [line for line in ax.lines if line.get_linewidth() == 2.5]
    assert len(rods) == (2 if name == "grasp_unequal" else 1)
    assert rods[0].get_xdata()[-1] == pytest.approx(1e3 * plan.tip.x)
    assert plan.title in ax.get_title()
    matplotlib.pyplot.close("all")


def test_shapes_stand_at_their_distance():
    from tendril._plot import _outline

    capsule = _outline({"shape": "capsule", "from": [0.0, 0.0], "to": [1.0, 0.0], "radius": 0.1})
    nearest = np.hypot(capsule[:, 0] - np.clip(capsule[:, 0], 0.0, 1.0), capsule[:, 1])
    assert nearest == pytest.approx(np.full(len(capsule), 0.1))


def test_forces_have_their_own_direction(brace):
    plan = brace.plan()
    arrow = next(c for c in plan.plot().collections if isinstance(c, matplotlib.quiver.Quiver))
    assert np.array([arrow.U[0], arrow.V[0]]) / np.hypot(arrow.U[0], arrow.V[0]) == pytest.approx(np.array(plan.contacts[0].normal))
    matplotlib.pyplot.close("all")


def test_animations(scenes, tmp_path):
    trajectory = tendril.load(scenes / "trajectory.toml").trajectory()
    few = tendril.Trajectory({**trajectory.to_dict(), "steps": trajectory.to_dict()["steps"][:3]})
    few.animate(tmp_path / "a.gif")
    few.animate(tmp_path / "a.html")
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF8")
    assert (tmp_path / "a.html").read_text().count("data:image/png") == 3
    few.plot()
    with pytest.raises(ValueError, match="file"):
        few.animate(tmp_path / "a.xyz")
    with pytest.raises(ValueError, match="fps"):
        few.animate(fps=0.0)
    matplotlib.pyplot.close("all")
