"""Results: the JSON documents of the command (docs/results.md) with names, types and arrays."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._scene import Scene

    Array = npt.NDArray[np.float64]

SCHEMA = 1


class _Malformed(ValueError):
    """A part of a document that cannot be read, and which."""


def json_text(document: Mapping[str, Any], name: str) -> str:
    """Raises TypeError or ValueError naming `name` where JSON cannot hold it."""
    import json

    try:
        text = json.dumps(document, ensure_ascii=False, allow_nan=False)
        text.encode()
        return text
    except (TypeError, ValueError, RecursionError) as error:
        kind = TypeError if isinstance(error, TypeError) else ValueError
        raise kind(f"{name}: found what JSON cannot hold: {error}") from None


class Tip(NamedTuple):
    """Where the tip is: m, m, rad."""

    x: float
    y: float
    angle: float


class Contact(NamedTuple):
    """A contact, SI: `normal` points out of the obstacle, `force` acts along it; under friction `tangential_force` along the
    rod, and `state`, "stick" or "slip". `extended`: the rod lies along the obstacle here.
    """

    obstacle: str
    arc_length: float
    point: tuple[float, float]
    normal: tuple[float, float]
    force: float
    gap: float
    at_tip: bool
    finger: str = ""
    tangential_force: float = 0.0
    state: str = ""
    extended: bool = False


class FrictionState(NamedTuple):
    """Where a plan's moments hold the rod if its contacts push so far off their normals. SI."""

    ratios: tuple[float, ...]
    tip: Tip
    contacts: list[Contact]
    stability: float
    target_error: float | None


class Result(Mapping[str, Any]):
    """A result as a mapping: `result["certificate"]["stability"]`, every key as docs/results.md has it."""

    problem: ClassVar[str] = ""
    _needs: ClassVar[Sequence[str]] = ()
    _scene: Scene | None = None  # that it is of, where that is known

    def __init__(self, document: Mapping[str, Any]) -> None:
        if not isinstance(document, Mapping):
            raise TypeError(f"document: found {type(document).__name__}, expected the dictionary of a result")
        if document.get("schema") != SCHEMA:
            raise ValueError(f"document: found schema {document.get('schema')!r}, expected {SCHEMA}")
        missing = [key for key in self._needs if key not in document]
        if missing:
            raise ValueError(f"document: found no '{missing[0]}', so it is no {type(self).__name__.lower()}")
        self._document = dict(document)
        self._arrays: dict[str, Any] = {}

    @classmethod
    def from_json(cls, text: str) -> Self:
        """The result of a JSON text, as the command writes it with --json. Raises ValueError if it is none."""
        import json

        if not isinstance(text, str):
            raise TypeError(f"text: found {type(text).__name__}, expected str")
        try:
            document = json.loads(text)
        except ValueError as error:
            raise ValueError(f"text: this is not JSON: {error}") from None
        return cls(document)

    @classmethod
    def from_file(cls, file: str | os.PathLike[str]) -> Self:
        """The result of a file."""
        with open(file, encoding="utf-8") as stream:
            return cls.from_json(stream.read())

    def to_dict(self) -> dict[str, Any]:
        """The same document as the command's JSON."""
        import json

        return json.loads(self.to_json())

    def to_json(self) -> str:
        """The document as text; `json.loads` of it is to_dict()."""
        return json_text(self._document, "document")

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the document to a file, for `start` here and for --start and --plan of the command."""
        text = self.to_json() + "\n"
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(text)

    def __getitem__(self, key: str) -> Any:
        return self._document[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._document)

    def __len__(self) -> int:
        return len(self._document)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._document == other._document  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        known = {"_scene": self._scene} if self._scene is not None else None
        return type(self).from_json, (self.to_json(),), known

    def _array(self, name: str, value: Any) -> Array:
        if name not in self._arrays:
            import numpy as np

            with self._part(name):
                self._arrays[name] = np.array(value, dtype=float)
            self._arrays[name].flags.writeable = False
        return self._arrays[name]

    @contextlib.contextmanager
    def _part(self, name: str) -> Iterator[None]:
        """What reads a part of the document says which, where the part is not as results have it."""
        try:
            yield
        except _Malformed:
            raise
        except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
            raise _Malformed(f"document: '{name}' is not as a result of this version has it: {error}") from None

    @property
    def status(self) -> str:
        """ "solved", or what is wrong."""
        return self._document.get("status", "")

    @property
    def solved(self) -> bool:
        return self.status == "solved"

    @property
    def message(self) -> str:
        """Why it is not solved, or what is to be known of it all the same."""
        return self._document.get("message", "")

    @property
    def title(self) -> str:
        return self._document.get("title", "")

    @property
    def seconds(self) -> dict[str, float]:
        return self._document.get("seconds", {})

    def view(self, file: str | os.PathLike[str]) -> None:
        """`tendril view`: writes a page that any browser opens (.html), a picture (.svg, .png, .pdf), or a movie (.gif, .mp4 with
        ffmpeg), drawn without matplotlib.
        """
        import warnings

        from ._components import components
        from ._native import view
        from ._values import file_path

        for note in view(self.to_json(), os.path.abspath(file_path(file, "file")), components()):
            warnings.warn(note, stacklevel=2)

    def row(self) -> dict[str, Any]:
        """The numbers of this result on one line, as pandas.DataFrame takes them."""
        return {"title": self.title, "status": self.status, "message": self.message}

    def __repr__(self) -> str:
        return f"<tendril.{type(self).__name__}: {', '.join(f'{k} {_shown(v)}' for k, v in self.row().items() if v not in ('', None))}>"

    def _repr_html_(self) -> str:
        return self._html([("th", key), ("td", value)] for key, value in self.row().items() if value not in ("", None))

    def _html_of(self, table: Sequence[Mapping[str, Any]]) -> str:
        """Lines below the keys that they have."""
        keys = list(dict.fromkeys(key for line in table for key in line))
        return self._html([[("th", key) for key in keys], *([("td", line.get(key)) for key in keys] for line in table)])

    def _html(self, lines: Iterable[Sequence[tuple[str, Any]]]) -> str:
        """A table of lines of cells, each with its kind."""
        import html

        def text(value: Any) -> str:
            return "" if value is None else html.escape(_shown(value))

        cells = ("".join(f"<{kind} style='text-align:left'>{text(value)}</{kind}>" for kind, value in line) for line in lines)
        return f"<table><caption>tendril.{type(self).__name__}</caption>{''.join(f'<tr>{line}</tr>' for line in cells)}</table>"


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


class _Shape(Result):
    """What has a backbone."""

    @property
    def backbone(self) -> Array:
        """One row per point: arc length, x, y, angle, curvature."""
        with self._part("backbone"):
            return self._array("backbone", self._document["backbone"] or []).reshape(-1, 5)

    @property
    def x(self) -> Array:
        """m, of the backbone's points"""
        return self.backbone[:, 1]

    @property
    def y(self) -> Array:
        """m, of the backbone's points"""
        return self.backbone[:, 2]

    @property
    def tip(self) -> Tip:
        with self._part("tip"):
            return _tip(self._document["tip"])

    @property
    def moments(self) -> Array:
        """N m, one per actuator."""
        return self._array("moments", self._document["moments"])

    @property
    def contacts(self) -> list[Contact]:
        with self._part("contacts"):
            return [_contact(c) for c in self._document["contacts"]]

    @property
    def thickness(self) -> Array | None:
        """m, diameter of the body at each point of the backbone; None: it is a line."""
        return self._array("thickness", self._document["thickness"]) if "thickness" in self._document else None

    def plot(self, ax: Any = None, *, deviations: float = 2.0, **style: Any) -> Any:
        """The body, the obstacles, the target and the contact forces, drawn with matplotlib. Returns the axes.

        Where the scene has error bars, a band shows where the body is to be expected, so many standard `deviations` to
        either side, with an ellipse at the tip. `style`: of the body's line.
        """
        from ._plot import plot

        return plot(self, ax, deviations, **style)

    def row(self) -> dict[str, Any]:
        row = super().row()
        if self._document.get("tip"):
            row.update(tip_x=self.tip.x, tip_y=self.tip.y, tip_angle=self.tip.angle)
        for i, moment in enumerate(self._document.get("moments") or []):
            row[f"moment_{i}"] = moment
        for i, contact in enumerate(self._document.get("contacts") or []):
            row[f"force_{i}"] = contact["force"]
        return row


def _pair(value: Any) -> Any:
    return None if value is None else (value[0], value[1])


def _tip(tip: Any) -> Tip:
    return Tip(tip["x"], tip["y"], tip["angle"])


def _contact(c: Any) -> Contact:
    return Contact(c.get("obstacle", ""), c["arc_length"], _pair(c.get("point")), _pair(c.get("normal")), c["force"], c.get("gap"),
                   c.get("at_tip", False), c.get("finger", ""), c.get("tangential_force", 0.0), c.get("state", ""),
                   c.get("extended", False))


class Finger(_Shape):
    """One finger of a grasp, in the world. Moments of the lower one are those of its mirror image."""

    _needs: ClassVar[Sequence[str]] = ("moments", "tip", "contacts", "backbone")


class Plan(_Shape):
    """A planned pose or grasp."""

    problem = "pose"
    _needs: ClassVar[Sequence[str]] = ("status", "backbone", "coordinates", "moments", "contacts", "certificate")

    @property
    def target_error(self) -> float | None:
        """m, distance of the tip to the target."""
        return self._document.get("target_error")

    @property
    def model_error(self) -> float | None:
        """m, with verify: distance of the tip to where execution takes it."""
        return self._document.get("model_error")

    @property
    def objective(self) -> float:
        """dimensionless, without penalties."""
        return self._document["objective"]

    @property
    def terms(self) -> dict[str, float]:
        """Weighted parts of the objective."""
        return self._document["terms"]

    @property
    def coordinates(self) -> Array:
        """dimensionless, of the coordinate model."""
        return self._array("coordinates", self._document["coordinates"].get("values", []))

    @property
    def certificate(self) -> dict[str, Any]:
        """dimensionless, see docs/results.md."""
        return self._document["certificate"]

    @property
    def inputs(self) -> Array:
        """One per actuator, each in SI of what it is told: a moment, a pressure, a tension or a shortening (see
        plan["inputs"])."""
        with self._part("inputs"):
            return self._array("inputs", [entry["value"] for entry in self._document["inputs"]])

    @property
    def fingers(self) -> list[Finger]:
        """The upper and the lower finger of a grasp that plans both; else empty."""
        with self._part("fingers"):
            return [Finger({"schema": SCHEMA, "status": self.status, **finger}) for finger in self._document.get("fingers", [])]

    @property
    def palm_distance(self) -> float | None:
        """m, of the object from the palm of a grasp."""
        return self._document.get("palm_distance")

    @property
    def net_force(self) -> Array | None:
        """N, x and y, of a grasp on its object."""
        return self._array("net_force", self._document["net_force"]) if "net_force" in self._document else None

    @property
    def held_forces(self) -> Array:
        """N, one row, x and y, per corner of the disturbing forces that friction holds in a grasp; none without friction."""
        with self._part("grasp"):
            corners = self._document.get("grasp", {}).get("friction", {}).get("held_forces", [])
            return self._array("held_forces", corners).reshape(-1, 2)

    @property
    def friction_range(self) -> list[FrictionState]:
        """The state without friction, then one for every corner of the cones of the contacts; empty: there is no friction."""
        with self._part("friction_range"):
            return [FrictionState(tuple(state["ratios"]), _tip(state["tip"]), [_contact(c) for c in state["contacts"]],
                                  state["stability"], state.get("target_error"))
                    for state in self._document.get("friction_range", [])]

    @property
    def moved_obstacles(self) -> dict[str, tuple[float, float, float]]:
        """Of a step of a trajectory, obstacles that are elsewhere than in the scene: x (m), y (m) and angle (rad) by which."""
        with self._part("moved_obstacles"):
            return {o["obstacle"]: (o["shift"][0], o["shift"][1], o["turn"]) for o in self._document.get("moved_obstacles", [])}

    @property
    def left_out(self) -> list[dict[str, str]]:
        """What the scene could have needed and did not, and why."""
        return self._document["left_out"]

    @property
    def uncertainty(self) -> dict[str, Any] | None:
        """Standard deviations of tip and contacts where the scene has error bars ("8 mm +- 0.2 mm"), moments held, and
        the share of each input; None: it has none."""
        return self._document.get("uncertainty")

    def sensitivity(self, key: str, *, held: bool = False) -> dict[str, float]:
        """Derivatives of the quantities of the plan by a number of its scene, SI: `plan.sensitivity("obstacle[0].radius")`.

        Nothing is planned: it is this plan that is differentiated. See Scene.sensitivity().
        """
        return self.sensitivities(key, held=held)[key]

    def sensitivities(self, *keys: str, held: bool = False) -> Sensitivities:
        """The same by several numbers, by default all of the scene."""
        if self._scene is None:
            raise TypeError("sensitivities: this result does not know its scene, expected one that Scene.plan(), trajectory() or "
                            "execute() gave; of a result from a file: scene.sensitivity(plan=result)")
        return self._scene.sensitivity(*keys, held=held, plan=self)

    def row(self) -> dict[str, Any]:
        row = super().row()
        row.update(objective=self._document.get("objective"), target_error=self.target_error,
                   model_error=self.model_error, stability=self.certificate.get("stability"))
        return row


class Execution(Plan):
    """What the rod does under given moments. They are held in its derivatives."""

    problem = "execute"
    _needs: ClassVar[Sequence[str]] = (*Plan._needs, "load", "snaps")

    @property
    def snaps(self) -> list[dict[str, Any]]:
        """Jumps to another stable state while the loads grow."""
        return self._document["snaps"]

    @property
    def load(self) -> float:
        """Fraction of the loads that was reached; 1 if all are on."""
        return self._document["load"]["reached"]


class Sensitivities(Result):
    """Derivatives of a plan, or of what the robot does under its held moments, by numbers of the scene; SI."""

    _needs: ClassVar[Sequence[str]] = ("kind", "quantities", "numbers")

    @property
    def held(self) -> bool:
        """Whether the moments stay; else everything is planned anew."""
        return self._document["kind"] == "held"

    @property
    def rows(self) -> list[str]:
        """Names of the quantities that are differentiated: "tip.x", "contacts[0].force", ..."""
        return [quantity["name"] for quantity in self._document["quantities"]]

    @property
    def columns(self) -> list[str]:
        """Keys of the numbers by which they are."""
        return [number["key"] for number in self._document["numbers"] if "derivatives" in number]

    @property
    def matrix(self) -> Array:
        """rows x columns."""
        import numpy as np

        columns = [number["derivatives"] for number in self._document["numbers"] if "derivatives" in number]
        return np.array(columns, dtype=float).reshape(len(columns), len(self.rows)).T

    @property
    def trouble(self) -> dict[str, str]:
        """By which numbers there are no derivatives, and why."""
        return {number["key"]: number["trouble"] for number in self._document["numbers"] if "trouble" in number}

    def table(self) -> list[dict[str, Any]]:
        """One line per number: its key, its value as the scene has it, and the derivatives, as pandas.DataFrame takes them."""
        return [{"number": n["key"], "value": n["value"], **dict(zip(self.rows, n.get("derivatives", [None] * len(self.rows))))}
                for n in self._document["numbers"]]

    def row(self) -> dict[str, Any]:
        return {"kind": self._document["kind"], "quantities": len(self.rows), "numbers": len(self.columns)}

    def _repr_html_(self) -> str:
        return self._html_of(self.table())

    def __getitem__(self, key: str) -> Any:
        for number in self._document["numbers"]:
            if number["key"] != key:
                continue
            if "trouble" in number:
                raise ValueError(f"{key}: {number['trouble']}")
            return dict(zip(self.rows, number["derivatives"], strict=True))
        return super().__getitem__(key)


class Calibration(Result):
    """Numbers of a rod found from measured shapes."""

    _needs: ClassVar[Sequence[str]] = ("numbers",)

    @property
    def numbers(self) -> list[dict[str, Any]]:
        """What was looked for: name, unit, value and error (standard deviation), None where it is not identifiable."""
        return self._document["numbers"]

    @property
    def found(self) -> Array:
        """SI, the value of each number; NaN where it is not identifiable."""
        return self._array("found", [number["value"] for number in self.numbers])

    @property
    def errors(self) -> Array:
        """Their standard deviations."""
        return self._array("errors", [number["error"] for number in self.numbers])

    @property
    def covariance(self) -> Array:
        """Of all numbers."""
        return self._array("covariance", self._document["covariance"])

    @property
    def identifiable(self) -> bool:
        """Whether all of them are."""
        return all(number["identifiable"] for number in self.numbers)

    def table(self) -> list[dict[str, Any]]:
        """One line per number, as pandas.DataFrame takes them."""
        return [{key: number[key] for key in ("name", "unit", "value", "error", "identifiable", "reason")} for number in self.numbers]

    def row(self) -> dict[str, Any]:
        return {**super().row(), **{n["name"]: n["value"] for n in self.numbers}, **{f"{n['name']}_error": n["error"] for n in self.numbers}}

    def _repr_html_(self) -> str:
        return self._html_of(self.table())


class Trajectory(Result):
    """Plans for a row of targets."""

    problem = "trajectory"
    _needs = ("steps",)

    @property
    def steps(self) -> list[Plan]:
        if "steps" not in self._arrays:
            shared = {"obstacles": self._document.get("obstacles", [])}
            self._arrays["steps"] = [Plan({**shared, **step}) for step in self._document["steps"]]
            for step in self._arrays["steps"]:
                step._scene = self._scene
        return self._arrays["steps"]

    @property
    def tips(self) -> Array:
        """One row per step: x, y, angle."""
        return self._array("tips", [step.tip for step in self.steps]).reshape(-1, 3)

    @property
    def moments(self) -> Array:
        """N m, one row per step, one column per actuator."""
        return self._array("moments", [step["moments"] for step in self.steps])

    @property
    def target_errors(self) -> Array:
        """m, one per step; nan where a step has no position to miss."""
        return self._array("target_errors", [step.target_error for step in self.steps])

    def animate(self, file: str | os.PathLike[str] | None = None, *, fps: float = 15.0, ax: Any = None) -> Any:
        """An animation of matplotlib; with `file` it is written as .gif, .mp4 or .html. Returns it."""
        from ._plot import animate

        return animate(self, file, fps, ax)

    def plot(self, ax: Any = None) -> Any:
        """All steps in one picture. Returns the axes."""
        from ._plot import plot_steps

        return plot_steps(self, ax)

    def row(self) -> dict[str, Any]:
        return {**super().row(), "steps": len(self._document["steps"]), **{
            f"target_error_{key}": value for key, value in (self._document.get("target_error") or {}).items()}}


class Estimate(_Shape):
    """Contacts told from measured points."""

    problem = "estimate"
    _needs = ("status", "contacts", "covariance")

    @property
    def covariance(self) -> Array:
        """Of force (N) and arc length (m) of each contact in turn."""
        return self._array("covariance", self._document["covariance"])


class SequenceEstimate(_Shape):
    """Contacts that are followed through a sequence of measured shapes. As a shape it is the last frame."""

    problem = "estimate"
    _needs = ("status", "frames", "rates")

    @property
    def frames(self) -> list[dict[str, Any]]:
        """Every frame as docs/results.md has it."""
        return self._document["frames"]

    @property
    def times(self) -> Array:
        """s, or the numbers of the frames."""
        with self._part("frames"):
            return self._array("times", [f["time"] if "time" in f else f["frame"] for f in self.frames])

    @property
    def numbers(self) -> list[int]:
        """Of the contacts, as they were made: the columns of the arrays below."""
        with self._part("frames"):
            return sorted({c["number"] for f in self.frames for c in f["contacts"]})

    def of_contacts(self, key: str, *, so_far: bool = False) -> Array:
        """One row per frame, one column per contact, NaN where it is not there: "force", "force_error" (N), "arc_length",
        "arc_length_error" (m) or "correlation", as all frames tell them, or as those up to each do.
        """
        with self._part("frames"):
            rows = [{c["number"]: (c["so_far"] if so_far else c)[key] for c in f["contacts"]} for f in self.frames]
            return self._array(f"{key} {so_far}", [[row.get(n) for n in self.numbers] for row in rows])

    @property
    def forces(self) -> Array:
        """N, as all frames tell them: of_contacts("force")."""
        return self.of_contacts("force")

    @property
    def force_errors(self) -> Array:
        """N, their standard deviations."""
        return self.of_contacts("force_error")

    @property
    def arc_lengths(self) -> Array:
        """m, as all frames tell them."""
        return self.of_contacts("arc_length")

    @property
    def arc_length_errors(self) -> Array:
        """m, their standard deviations."""
        return self.of_contacts("arc_length_error")


class Description(Result):
    """The program that a scene becomes."""

    _needs = ("variables", "rows")

    @property
    def variables(self) -> dict[str, int]:
        """How many there are, by name."""
        return {v["name"]: v["count"] for v in self._document["variables"]}

    @property
    def rows(self) -> dict[str, int]:
        """How many constraints there are, by name."""
        return {r["name"]: r["count"] for r in self._document["rows"]}

    @property
    def left_out(self) -> list[dict[str, str]]:
        """What the scene could have needed and did not, and why."""
        return self._document["left_out"]

    def row(self) -> dict[str, Any]:
        return {"title": self.title, **self.variables, **self.rows}


class Study(Result):
    """Every combination of the sweeps that a scene declares."""

    _needs = ("cases",)

    @property
    def cases(self) -> list[dict[str, Any]]:
        return self._document["cases"]

    @property
    def groups(self) -> list[dict[str, Any]]:
        return self._document.get("groups", [])

    @property
    def solved(self) -> bool:
        return all(case.get("status") == "solved" for case in self.cases)

    def of_cases(self, key: str) -> Array:
        """One row per case of what they tell under a key, "tip_error", "moments", ...; NaN where one does not."""
        with self._part(key):
            told = [case.get(key) for case in self.cases]
            size = max((len(value) for value in told if isinstance(value, list)), default=0)
            lists = [value if isinstance(value, list) else [None] * size for value in told]
            rows = [value + [None] * (size - len(value)) for value in lists]
            return self._array(f"cases {key}", rows if size else told)

    def table(self) -> list[dict[str, Any]]:
        """One line per case, its plain values alone, as pandas.DataFrame takes them."""
        return [{k: v for k, v in case.items() if not isinstance(v, (list, dict))} for case in self.cases]

    def row(self) -> dict[str, Any]:
        return {"title": self.title, "cases": len(self.cases)}

    def _repr_html_(self) -> str:
        return self._html_of(self.table())
