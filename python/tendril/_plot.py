"""Pictures with matplotlib, which is loaded when the first one is asked for. Lengths are in mm."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ._results import Trajectory, _Shape

_MM = 1e3
_OBSTACLE = {"facecolor": "0.85", "edgecolor": "0.4", "zorder": 1}


def _axes(ax: Any) -> Any:
    if ax is None:
        import matplotlib.pyplot as plt

        ax = plt.subplots(layout="constrained")[1]
    ax.set_aspect("equal")
    ax.set_xlabel("x in mm")
    ax.set_ylabel("y in mm")
    return ax


def _outline(obstacle: dict[str, Any]) -> Any:
    """Points around an obstacle, m, one per row; None for a shape that is not known here."""
    if obstacle["shape"] == "circle":
        return _grown(np.array([obstacle["center"]]), obstacle["radius"])
    if obstacle["shape"] == "capsule":
        return _grown(np.array([obstacle["from"], obstacle["to"]]), obstacle["radius"])
    return None


def _grown(corners: Any, radius: float) -> Any:
    """Points around the convex hull of corners, grown by a radius: in each direction the farthest corner, and more."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    return corners[np.argmax(circle @ corners.T, axis=1)] + radius * circle


def _draw_polygon(ax: Any, obstacle: dict[str, Any]) -> None:
    """The outlines as one path, whose holes run the other way, and each of their sides grown by the rounding."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    vertices = np.array(obstacle["vertices"])
    ends = np.cumsum([int(n) for n in obstacle.get("outlines", [len(vertices)])])
    fill = {"facecolor": _OBSTACLE["facecolor"], "edgecolor": "none", "zorder": _OBSTACLE["zorder"]}
    outlines = [np.vstack([part, part[:1]]) for part in np.split(vertices, ends[:-1])]
    ax.add_patch(PathPatch(Path.make_compound_path(*[Path(_MM * o, closed=True) for o in outlines]), **fill))
    for outline in outlines:
        for side in zip(outline[:-1], outline[1:]):
            ax.fill(*(_MM * _grown(np.array(side), obstacle["rounding"]).T), **fill)


def _draw_channel(ax: Any, obstacle: dict[str, Any]) -> None:
    """Both walls, half of the width beside the middle."""
    points = np.array(obstacle["points"])
    widths = np.array(obstacle.get("widths", [obstacle.get("width")] * len(points)))
    along = np.gradient(points, axis=0)
    across = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    for side in (0.5, -0.5):
        ax.plot(*(_MM * (points + side * widths[:, None] * across).T), color=_OBSTACLE["edgecolor"], zorder=1)


def _draw_scene(ax: Any, result: Any) -> None:
    for obstacle in result.get("obstacles") or []:
        if obstacle["shape"] == "wall":
            angle = obstacle.get("angle")
            along = (-obstacle["normal"][1], obstacle["normal"][0]) if angle is None else (np.cos(angle), np.sin(angle))
            start = _MM * np.array(obstacle["point"])
            ax.axline(start, start + np.array(along), color="0.4", zorder=1)
        if obstacle["shape"] == "polygon":
            _draw_polygon(ax, obstacle)
        if obstacle["shape"] == "channel":
            _draw_channel(ax, obstacle)
        outline = _outline(obstacle)
        if outline is not None:
            ax.fill(*(_MM * outline.T), **_OBSTACLE)
    grasped = (result.get("grasp") or {}).get("object")
    if grasped:
        ax.fill(*(_MM * _outline({"shape": "circle", **grasped}).T), **_OBSTACLE)


def plot(result: _Shape, ax: Any = None, **style: Any) -> Any:
    ax = _axes(ax)
    _draw_scene(ax, result)
    style = {"color": "C0", "linewidth": 2.5, "solid_capstyle": "round", "zorder": 3, **style}
    fingers = result.get("fingers") or [result]
    for finger in fingers:
        points = np.array(finger["backbone"]).reshape(-1, 5)
        ax.plot(_MM * points[:, 1], _MM * points[:, 2], **style)
    pressed = [c for c in result.contacts if c.point and c.force and c.force > 0.0]
    if pressed:
        size = 0.15 * result["backbone"][-1][0] / max(c.force for c in pressed)
        starts = np.array([c.point for c in pressed])
        arrows = np.array([np.multiply(c.normal, c.force * size) for c in pressed])
        ax.quiver(*(_MM * starts.T), *(_MM * arrows.T), color="C3", angles="xy", scale_units="xy", scale=1.0, width=0.005, zorder=4)
        ax.update_datalim(_MM * (starts + 1.2 * arrows))  # arrows alone leave the limits as they are
        for contact, start, arrow in zip(pressed, starts, arrows):
            ax.annotate(f"{contact.force:.3g} N", _MM * (start + arrow), color="C3", textcoords="offset points", xytext=(4, 4))
    target = (result.get("target") or {}).get("position")
    if target:
        ax.plot(_MM * target[0], _MM * target[1], "+", color="C2", markersize=10, zorder=4)
    ax.autoscale_view()
    ax.set_title(f"{result.title}" + ("" if result.solved else f" ({result.status})"))
    return ax


def plot_steps(trajectory: Trajectory, ax: Any = None) -> Any:
    ax = _axes(ax)
    _draw_scene(ax, trajectory)
    import matplotlib

    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.9, max(len(trajectory.steps), 1)))
    for step, colour in zip(trajectory.steps, colours):
        ax.plot(_MM * step.x, _MM * step.y, color=colour, linewidth=1.0, zorder=2)
    ax.plot(_MM * trajectory.tips[:, 0], _MM * trajectory.tips[:, 1], ".", color="C3", markersize=3, zorder=3)
    ax.set_title(trajectory.title)
    return ax


def animate(trajectory: Trajectory, file: str | os.PathLike[str] | None, fps: float, ax: Any) -> Any:
    from matplotlib.animation import FuncAnimation

    if not trajectory.steps:
        raise ValueError("trajectory: found no step, so there is nothing to show")
    if not fps > 0.0:
        raise ValueError(f"fps: found {fps!r}, expected a number above 0")
    name = None if file is None else os.fspath(file)
    if name is not None and not name.endswith((".gif", ".mp4", ".html")):
        raise ValueError(f"file: found {name!r}, expected a name that ends in .gif, .mp4 or .html")
    ax = _axes(ax)
    points = _MM * np.vstack([step.backbone[:, 1:3] for step in trajectory.steps])
    margin = 0.1 * np.ptp(points, axis=0).max()

    def frame(i: int) -> list[Any]:
        ax.clear()
        plot(trajectory.steps[i], ax)
        ax.plot(_MM * trajectory.tips[: i + 1, 0], _MM * trajectory.tips[: i + 1, 1], color="C1", linewidth=1.0)
        ax.set_xlim(points[:, 0].min() - margin, points[:, 0].max() + margin)
        ax.set_ylim(points[:, 1].min() - margin, points[:, 1].max() + margin)
        return []

    animation = FuncAnimation(ax.figure, frame, frames=len(trajectory.steps), interval=1e3 / fps)
    if name is not None and name.endswith(".html"):
        with open(name, "w", encoding="utf-8") as stream:
            stream.write(animation.to_jshtml(fps=fps))
    elif name is not None:
        animation.save(name, writer="pillow" if name.endswith(".gif") else "ffmpeg", fps=fps)
    return animation
