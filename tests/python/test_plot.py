"""Pictures: what is drawn, and files that are what their names say."""

import json
import shutil
import subprocess

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest

import tendril

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


def test_what_is_no_plan_does_not_look_like_one(brace):
    plan = brace.plan()
    for one in (plan, tendril.Plan({**plan.to_dict(), "status": "unstable"})):
        ax = one.plot()
        [rod] = [line for line in ax.lines if line.get_linewidth() == 2.5]
        assert (rod.get_linestyle() == "-") == (rod.get_color() == "C0") == ("(unstable)" not in ax.get_title()) == one.solved
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


def test_a_band_is_as_wide_as_the_shape_is_uncertain(scenes):
    """Of a free rod whose stiffness is known to 5 %: the tip's two standard deviations are those of two executions."""
    scene = tendril.load(scenes / "free.toml").copy({"rod.bending_stiffness": "4.9e-4 N m^2 +- 5 %"})
    plan = scene.plan()
    ax = plan.plot(deviations=2.0)
    band = ax.patches[-1].get_path().vertices[:-1]
    one, other = band[len(band) // 2 - 1], band[len(band) // 2]
    across = np.array([-np.sin(plan.tip.angle), np.cos(plan.tip.angle)])
    tips = np.array([scene.copy({"rod.bending_stiffness": 4.9e-4 * (1 + side * 1e-3)}).execute(plan.moments).tip[:2] for side in (-1, 1)])
    deviation = 1e3 * abs((tips[1] - tips[0]) @ across) / 2e-3 * 0.05
    assert np.linalg.norm(one - other) == pytest.approx(4.0 * deviation, rel=1e-3)
    assert 0.5 * (one + other) == pytest.approx(1e3 * np.array(plan.tip[:2]))
    before = len(ax.patches)
    assert len(plan.plot(deviations=0.0).patches) == before - 1
    for deviations in (-1.0, float("nan"), "two", None):
        with pytest.raises((TypeError, ValueError), match="deviations"):
            plan.plot(deviations=deviations)
    with pytest.raises(TypeError, match="ax"):
        plan.plot(3)
    matplotlib.pyplot.close("all")


FFMPEG = """#!/usr/bin/python3
# Stands for ffmpeg: keeps how many bytes of pictures of which size it is given.
import sys
size = sys.argv[sys.argv.index("-s") + 1] if "-s" in sys.argv else ""
open(sys.argv[-1], "w").write(f"{size} {len(sys.stdin.buffer.read())}")
"""


def test_a_film_goes_through_ffmpeg(scenes, tmp_path, monkeypatch):
    document = tendril.load(scenes / "trajectory.toml").trajectory().to_dict()
    few = tendril.Trajectory({**document, "steps": document["steps"][:3]})
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match="file: found .*a.mp4.*ffmpeg"):
        few.animate(tmp_path / "a.mp4")
    (tmp_path / "ffmpeg").write_text(FFMPEG)
    (tmp_path / "ffmpeg").chmod(0o755)
    few.animate(tmp_path / "a.mp4")
    size, count = (tmp_path / "a.mp4").read_text().split()
    width, height = map(int, size.split("x"))
    assert int(count) == 3 * 4 * width * height
    matplotlib.pyplot.close("all")


@pytest.mark.skipif(not (shutil.which("ffmpeg") and shutil.which("ffprobe")), reason="ffmpeg is not installed")
def test_a_film_has_a_frame_for_each_step(scenes, tmp_path):
    document = tendril.load(scenes / "trajectory.toml").trajectory().to_dict()
    few = tendril.Trajectory({**document, "steps": document["steps"][:5]})
    few.animate(tmp_path / "a.mp4", fps=5.0)
    asked = ["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=codec_name,pix_fmt,r_frame_rate,nb_read_frames", "-of", "json"]
    told = subprocess.run([*asked, tmp_path / "a.mp4"], capture_output=True, check=True)
    (stream,) = json.loads(told.stdout)["streams"]
    # What browsers and slides show.
    assert stream == {"codec_name": "h264", "pix_fmt": "yuv420p", "r_frame_rate": "5/1", "nb_read_frames": "5"}
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
    for fps in (0.0, float("nan"), "fast"):
        with pytest.raises((TypeError, ValueError), match="fps"):
            few.animate(fps=fps)
    with pytest.raises(TypeError, match="file"):
        few.animate(3)
    matplotlib.pyplot.close("all")
