"""Pictures: what is drawn, and files that are what their names say."""

import numpy as np
import pytest

import tendril

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")


@pytest.mark.parametrize("name", ["brace", "ledge", "table", "grasp_60mm", "grasp_unequal", "silicone_finger", "window"])
def test_plot(scenes, name):
    plan = tendril.load(scenes / f"{name}.toml").plan()
    ax = plan.plot()
    rods = [line for line in ax.lines if line.get_linewidth() == 2.5]
    assert len(rods) == (2 if name.startswith("grasp") else 1)
    assert rods[0].get_xdata()[-1] == pytest.approx(1e3 * plan.tip.x)
    assert plan.title in ax.get_title()
    matplotlib.pyplot.close("all")


def test_draws_what_the_page_shows(scenes):
    plan = tendril.load(scenes / "brace.toml").copy({"contact.friction": 0.3}).plan()
    ax = plan.plot()
    peg, cone = (patch.get_path().vertices for patch in ax.patches)
    assert np.hypot(peg[:, 0] - 60.0, peg[:, 1]) == pytest.approx(np.full(len(peg), 8.0), abs=1e-3)
    # From the contact its sides rise by the coefficient of friction.
    middle = 0.5 * (cone[1] + cone[2])
    assert np.linalg.norm(cone[1] - cone[2]) == pytest.approx(2 * 0.3 * np.linalg.norm(middle - cone[0]))
    matplotlib.pyplot.close("all")


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
