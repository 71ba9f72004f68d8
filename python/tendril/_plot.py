"""Pictures with matplotlib, which is loaded when the first one is asked for, of the document of docs/drawing.md."""

from __future__ import annotations

import json
import os
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from ._components import components
from ._native import drawing
from ._values import file_path, number

if TYPE_CHECKING:
    from ._results import Result, Trajectory, _Shape

_OBSTACLE = {"facecolor": "0.85", "edgecolor": "0.4", "zorder": 1}


def _doubtful(frame: dict[str, Any]) -> dict[str, Any]:
    """How a line is drawn that is no plan, or no state of rest; one that is needs nothing."""
    return {} if frame.get("status", "solved") == "solved" else {"color": "0.6", "linestyle": "--"}


class _Picture:
    """Axes, and a drawing in its own unit of length."""

    def __init__(self, result: Result, ax: Any) -> None:
        self.drawing: dict[str, Any] = json.loads(drawing(result.to_json(), components()))
        for note in self.drawing["notes"]:
            warnings.warn(note, stacklevel=4)
        if ax is not None and not hasattr(ax, "set_aspect"):
            raise TypeError(f"ax: found {ax!r}, expected axes of matplotlib")
        if ax is None:
            import matplotlib.pyplot as plt

            ax = plt.subplots(layout="constrained")[1]
        self.ax = ax
        self.per_metre = 1.0 / self.drawing["length_unit"]["size"]
        forces = [c.get("force", 0.0) for frame in self.drawing["frames"] for c in frame["contacts"]]
        self.per_newton = 0.15 * self.drawing["length"] / max([*forces, 0.0]) if max([*forces, 0.0]) > 0.0 else 0.0

    def points(self, points: Any) -> Any:
        """Two rows, x and y, in the unit of the axes."""
        return self.per_metre * np.array(points, dtype=float).reshape(-1, 2).T

    def surroundings(self, *frames: dict[str, Any]) -> None:
        unit = self.drawing["length_unit"]["name"]
        self.ax.set_aspect("equal")
        self.ax.set_xlabel(f"x in {unit}")
        self.ax.set_ylabel(f"y in {unit}")
        for shape in [*self.drawing["obstacles"], *(shape for frame in frames for shape in frame.get("obstacles", []))]:
            self.area(shape["outlines"], **(_OBSTACLE if not shape.get("ignored") else {"facecolor": "none", "edgecolor": "0.5", "linestyle": "--"}))
        # Obstacles may go on for ever; the rod says what is looked at.
        near = 0.35 * self.drawing["length"] * self.per_metre
        lines = [self.points(line) for frame in frames for rod in frame["rods"] for line in (rod["line"], rod.get("body", []), rod.get("band", []))]
        if lines:
            points = np.hstack(lines)
            self.ax.set_xlim(points[0].min() - near, points[0].max() + near)
            self.ax.set_ylim(points[1].min() - near, points[1].max() + near)

    def area(self, outlines: Any, **style: Any) -> None:
        """What lies within an odd number of lines: as one path, in which holes run the other way."""
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path

        self.ax.add_patch(PathPatch(Path.make_compound_path(*[Path(self.points([*o, o[0]]).T, closed=True) for o in outlines]), **style))

    def frame(self, frame: dict[str, Any], **style: Any) -> None:
        """The rods, what touches them, and where they should be."""
        for contact in frame["contacts"]:
            if contact.get("friction") and contact.get("force", 0.0) > 0.0:
                self.cone(contact)
        style = {"color": "C0", "linewidth": 2.5, "solid_capstyle": "round", "zorder": 3, **_doubtful(frame), **style}
        for rod in frame["rods"]:
            if "band" in rod:
                self.area([rod["band"]], facecolor="C1", edgecolor="none", alpha=0.3, zorder=1)
            if "body" in rod:
                self.area([rod["body"]], facecolor=style["color"], edgecolor="none", alpha=0.3, zorder=2)
            self.ax.plot(*self.points(rod["line"]), **style)
        for key, mark, color in (("measured", "o", "C1"), ("tips", "o", "C4"), ("path", ".", "C2")):
            self.ax.plot(*self.points(frame.get(key, [])), mark, color=color, fillstyle="none", zorder=4)
        if hold := frame.get("hold"):
            line = np.array(hold["center"]) + self.per_newton * np.array([*hold["forces"], hold["forces"][0]])
            self.ax.plot(*self.points(line), "--", color="C4", zorder=4)
        self.contacts([c for c in frame["contacts"] if c.get("force", 0.0) > 0.0])
        target = frame.get("target", {}).get("position")
        if target:
            self.ax.plot(*self.points(target), "+", color="C2", markersize=10, zorder=4)

    def band(self, backbone: Any, shape: Any, color: Any, deviations: float) -> None:
        """Where the body is to be expected: across it as many standard deviations of its points to either side, and about the
        tip the ellipse of both directions."""
        known = np.array(shape, dtype=float).reshape(-1, 4)
        x, y, angle = (np.interp(known[:, 0], backbone[:, 0], column) for column in backbone[:, 1:4].T)
        middle, across = np.stack([x, y], axis=1), np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        covariances = known[:, [1, 2, 2, 3]].reshape(-1, 2, 2)
        width = deviations * np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", across, covariances, across), 0.0))[:, None]
        style = {"facecolor": color, "edgecolor": "none", "alpha": 0.25, "zorder": 2}
        self.area([np.concatenate([middle + width * across, (middle - width * across)[::-1]])], **style)
        size, axes = np.linalg.eigh(covariances[-1])
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        round_tip = (axes * (deviations * np.sqrt(np.maximum(size, 0.0)))) @ np.stack([np.cos(turn), np.sin(turn)])
        self.ax.plot(*self.points(middle[-1] + round_tip.T), color=color, linewidth=1.0, zorder=3)

    def cone(self, contact: dict[str, Any]) -> None:
        size = self.per_newton * contact["force"]
        top = np.array(contact["surface"]) + size * np.array(contact["normal"])
        half = contact["friction"] * size * np.array(contact["tangent"])
        self.area([[contact["surface"], top + half, top - half]], facecolor="C3", edgecolor="none", alpha=0.2, zorder=2)

    def contacts(self, pressed: list[dict[str, Any]]) -> None:
        if not pressed:
            return
        starts = self.points([c["surface"] for c in pressed]).T
        arrows = self.points([np.multiply(c["normal"], c["force"] * self.per_newton) for c in pressed]).T
        style = {"color": "C3", "angles": "xy", "scale_units": "xy", "scale": 1.0, "zorder": 4}
        self.ax.quiver(*starts.T, *arrows.T, width=0.005, **style)
        for contact, start, arrow in zip(pressed, starts, arrows):
            up = arrow[1] >= 0.0
            self.ax.annotate(f"{contact['force']:.3g} N", start + arrow, color="C3", textcoords="offset points",
                             xytext=(4, 4 if up else -4), va="bottom" if up else "top")
            if contact.get("tangential_force"):
                along = self.points(np.multiply(contact["tangent"], contact["tangential_force"] * self.per_newton))[:, 0]
                self.ax.quiver(*start, *along, width=0.003, **style)


def plot(result: _Shape, ax: Any, deviations: float, **style: Any) -> Any:
    deviations = number(deviations, "deviations", 0.0, 1e6)
    picture = _Picture(result, ax)
    frame = picture.drawing["frames"][-1]
    picture.surroundings(frame)
    picture.frame(frame, **style)
    uncertainty = result.get("uncertainty") or {}
    if deviations > 0.0 and "shape" in uncertainty:
        picture.band(result.backbone, uncertainty["shape"], style.get("color", "C0"), deviations)
    picture.ax.set_title(f"{result.title}" + ("" if result.solved else f" ({result.status})"))
    return picture.ax


def plot_steps(trajectory: Trajectory, ax: Any = None) -> Any:
    picture = _Picture(trajectory, ax)
    frames = picture.drawing["frames"]
    picture.surroundings(*frames)
    import matplotlib

    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.9, max(len(frames), 1)))
    for frame, colour in zip(frames, colours):
        for rod in frame["rods"]:
            picture.ax.plot(*picture.points(rod["line"]), **{"color": colour, "linewidth": 1.0, "zorder": 2, **_doubtful(frame)})
    picture.ax.plot(*picture.points([rod["line"][-1] for frame in frames for rod in frame["rods"]]), ".", color="C3", markersize=3, zorder=3)
    picture.ax.set_title(trajectory.title)
    return picture.ax


def animate(trajectory: Trajectory, file: str | os.PathLike[str] | None, fps: float, ax: Any) -> Any:
    from matplotlib.animation import FFMpegWriter, FuncAnimation

    if not trajectory.steps:
        raise ValueError("trajectory: found no step, so there is nothing to show")
    fps = number(fps, "fps", 1e-3, 1e3)
    name = None if file is None else file_path(file, "file")
    if name is not None and not name.endswith((".gif", ".mp4", ".html")):
        raise ValueError(f"file: found {name!r}, expected a name that ends in .gif, .mp4 or .html")
    if name is not None and name.endswith(".mp4") and not FFMpegWriter.isAvailable():
        raise ValueError(f"file: found {name!r}, but ffmpeg, which writes .mp4, is not installed; expected it, or .gif or .html")
    picture = _Picture(trajectory, ax)
    frames = picture.drawing["frames"]
    tips = picture.points([rod["line"][-1] for frame in frames for rod in frame["rods"][:1]])

    def frame(i: int) -> list[Any]:
        picture.ax.clear()
        picture.surroundings(*frames)
        picture.frame(frames[i])
        picture.ax.plot(*tips[:, : i + 1], color="C1", linewidth=1.0)
        picture.ax.set_title(f"{trajectory.title}, {frames[i]['label']}")
        return []

    animation = FuncAnimation(picture.ax.figure, frame, frames=len(frames), interval=1e3 / fps)
    if name is not None and name.endswith(".html"):
        with open(name, "w", encoding="utf-8") as stream:
            stream.write(animation.to_jshtml(fps=fps))
    elif name is not None:
        animation.save(name, writer="pillow" if name.endswith(".gif") else "ffmpeg", fps=fps)
    return animation
