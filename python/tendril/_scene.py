"""A scene: what a scene file says, changed key by key, and everything that the command does with it."""

from __future__ import annotations

import os
import re
import sys
import warnings as _warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Union, overload

from . import _native
from ._components import components
from ._pool import Progress, reporting
from ._results import (
    Calibration, Description, Estimate, Execution, Plan, Result, Sensitivities, SequenceEstimate, Study, Trajectory, json_text,
)
from ._values import each, entries, file_path, inline, is_list, key_text, plain, unicode, whole_number

File = Union[str, "os.PathLike[str]"]
Earlier = Union[Result, str, "os.PathLike[str]", Mapping[str, Any]]
_STEP = re.compile(r"\.|\[(\d+)\]")


def load(file: str | os.PathLike[str], *, plugin_directories: Sequence[str | os.PathLike[str]] = ()) -> Scene:
    """The scene of a TOML file. Files that it names are looked for beside it.

    Raises OSError if it cannot be read, and Error, with file, line and column, if it is no scene.
    """
    path = file_path(file, "file")
    with open(path, encoding="utf-8", newline="") as stream:
        try:
            text = stream.read()
        except UnicodeDecodeError as error:
            raise ValueError(f"{path}: this is not UTF-8: {error}") from error
    scene = Scene.from_toml(text, file=path, plugin_directories=plugin_directories)
    scene._open()
    return scene


class Scene:
    """A scene. `Scene(rod={"length": "100 mm", ...}, target={...})` makes one of tables as a scene file has them;
    numbers are SI, text has a unit, quantities of pint and arrays of numpy do as well.

    Keys are read and set by their path: `scene["contact.max_force"] = "2 N"`, `scene["obstacle[0].radius"]`. What a key
    means, its unit and its default stand in docs/scene-keys.md.
    """

    def __init__(self, tables: Mapping[str, Any] | None = None, /, *,
                 plugin_directories: Sequence[str | os.PathLike[str]] = (), **keys: Any) -> None:
        self._file = "scene"
        self._text = ""
        self._settings: list[tuple[str, str, bool, str]] = []
        self._plugin_directories = [file_path(d, "plugin_directories") for d in each(plugin_directories, "plugin_directories")]
        self._table: dict[str, Any] | None = None
        content = {**_mapping(tables, "tables"), **keys}
        if content:
            lines = [(key_text(key, "Scene"), inline(value, str(key))) for key, value in content.items()]
            # Written out by the library, so that messages tell a line of what to_toml() shows.
            self._text = _native.scene_text(self._file, "".join(f"{key} = {value}\n" for key, value in lines), [])

    @classmethod
    def from_toml(cls, text: str, *, file: str | os.PathLike[str] = "scene",
                  plugin_directories: Sequence[str | os.PathLike[str]] = ()) -> Scene:
        """The scene of a TOML text. `file` names it in messages; files that it names are looked for beside that."""
        if not isinstance(text, str):
            raise TypeError(f"text: found {type(text).__name__}, expected str")
        scene = cls(plugin_directories=plugin_directories)
        scene._file, scene._text = file_path(file, "file"), unicode(text, "text")
        return scene

    # Keys

    def to_toml(self) -> str:
        """The scene as a TOML document, with everything that was set."""
        return _native.scene_text(self._file, self._text, self._settings)

    def to_dict(self) -> dict[str, Any]:
        """The scene's tables, values as they were written."""
        import copy

        return copy.deepcopy(self._tables())

    def _tables(self) -> dict[str, Any]:
        if self._table is None:
            import tomllib

            self._table = tomllib.loads(self.to_toml())
        return self._table

    def __getitem__(self, key: str) -> Any:
        node: Any = self._tables()
        for step in _steps(key):
            try:
                node = node[int(step)] if isinstance(node, list) else node[step]
            except (KeyError, IndexError, ValueError, TypeError):
                raise KeyError(f"the scene does not set '{key}'") from None
        return node

    def __contains__(self, key: object) -> bool:
        try:
            self[key]  # type: ignore[index]
        except (KeyError, TypeError, ValueError):
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables())

    def _ipython_key_completions_(self) -> list[str]:
        """The paths of all that is set, which a notebook offers behind `scene["`."""
        return list(_paths("", self._tables()))

    def __setitem__(self, key: str, value: Any) -> None:
        _steps(key)
        if isinstance(value, str):
            setting = (key, unicode(value, key), True, f'scene["{key}"] = "{value}"')
        else:
            text = inline(value, key)
            setting = (key, text, False, f'scene["{key}"] = {text}')
        _native.scene_text(self._file, self._text, [*self._settings, setting])  # refuses a path that leads nowhere
        self._settings.append(setting)
        self._table = None

    def __delitem__(self, key: str) -> None:
        *path, last = _steps(key)
        tables = self.to_dict()
        node: Any = tables
        try:
            for step in path:
                node = node[int(step)] if isinstance(node, list) else node[step]
            del node[int(last) if isinstance(node, list) else last]
        except (KeyError, IndexError, ValueError, TypeError):
            raise KeyError(f"the scene does not set '{key}'") from None
        self._text = "".join(f"{key_text(k, k)} = {inline(v, k)}\n" for k, v in tables.items())
        self._text = _native.scene_text(self._file, self._text, [])
        self._settings, self._table = [], None

    def copy(self, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Scene:
        """Another scene with some keys set: `copy(contact={"max_force": "2 N"})`, `copy({"rod.length": 0.2})`. A table
        changes the keys that it names and leaves the others.
        """
        other = Scene.__new__(Scene)
        other.__setstate__(self.__getstate__())
        for key, value in {**_mapping(changes, "changes"), **keys}.items():
            for path, leaf in _leaves(key, value):
                other[path] = leaf
        return other

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_settings": list(self._settings), "_table": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self._tables() == other._tables()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        tables = self._tables()
        return f"<tendril.Scene {tables.get('title', self._file)!r}: {tables.get('problem', 'pose')}>"

    # What the command does

    def _source(self) -> Any:
        return self._file, self._text, self._settings, self._plugin_directories, components()

    def _open(self) -> Any:
        opened = _native.SceneFile(self._source())
        self._warn(opened.warnings)
        return opened

    def _warn(self, warnings: Iterable[str]) -> None:
        for warning in warnings:
            _warnings.warn(warning, stacklevel=4)

    def plan(self, *, start: Earlier | None = None, verify: bool = False,
             progress: Progress = False) -> Plan | Trajectory | Estimate | SequenceEstimate:
        """`tendril plan`: a pose, a grasp, a trajectory or an estimate, whatever the scene asks for.

        `start`: an earlier result to start from. `verify`: the plan is executed on a fine basis, and its verdict
        depends on it. A plan that is not solved is no error: see `status` and `message`. `progress`: called with how many
        steps of a trajectory are finished and how many there are, of a plan with how many programs a solver has run and 0;
        or True for a bar (of tqdm, if it is there).
        """
        scene = self._open()
        if scene.problem == "trajectory":
            _refuse(start is not None, "start", "a trajectory starts from its scene")
            with reporting(progress) as report:
                text = scene.plan_trajectory(bool(verify), report if progress else None)
            return self._known(Trajectory.from_json(text))
        if scene.problem == "estimate":
            _refuse(start is not None, "start", "an estimate starts from the measured points")
            _refuse(verify, "verify", "the obstacles of an estimate are not known, so nothing can be carried out")
            found = Result.from_json(_native.estimate(self._source()))
            return SequenceEstimate(found) if "frames" in found else Estimate(found)
        with reporting(progress) as report:
            text = scene.plan(_json_of(start, "start"), bool(verify), report if progress else None)
        return self._known(Plan.from_json(text))

    def _known(self, result: Any) -> Any:
        """The result, which knows from now on that it is of this scene."""
        result._scene = self.copy()
        return result

    def trajectory(self, *, verify: bool = False, progress: Progress = False) -> Trajectory:
        """`tendril plan` of a scene with problem = "trajectory"."""
        return self._plan_as(Trajectory, verify=verify, progress=progress)

    def estimate(self) -> Estimate | SequenceEstimate:
        """`tendril plan` of a scene with problem = "estimate": of a single shape, or of a sequence of shapes."""
        return self._plan_as(Estimate)

    def _plan_as(self, kind: Any, **options: Any) -> Any:
        asked = self["problem"] if "problem" in self else "pose"
        _refuse(asked != kind.problem, "problem", f"found {asked!r}, expected {kind.problem!r}")
        return self.plan(**options)

    def execute(self, moments: Iterable[Any] | Earlier | None = None, *, pressures: Iterable[Any] | None = None,
                inputs: Iterable[Any] | None = None, plan: Earlier | None = None, start: Earlier | None = None,
                insertion: Any = None, base: Iterable[Any] | None = None) -> Execution | Trajectory:
        """`tendril execute`: what the rod does under `moments` (N m), `pressures` (Pa) or `inputs` (each in the unit of its
        actuator: a pressure where the scene has moment_per_pressure, the tension of a tendon or the shortening of one
        told its length, a moment), one per actuator, or under what an earlier result, `plan`, holds.

        `insertion`: how much of the rod is out of its port (m); `base`: x (m), y (m) and angle (rad) of its clamp. They are
        held, and led there from `start`, at its moments where none are given; beside `plan` they stand for its own.

        A list of such lists, or of insertions, is a way, and gives a Trajectory: each is executed from where the one before
        it ends, and what is given once holds all along.
        """
        if isinstance(moments, (Result, Mapping)):
            moments, plan = None, moments
        given = {"moments": moments, "pressures": pressures, "inputs": inputs}
        told = [name for name, value in given.items() if value is not None]
        if len(told) + (plan is not None) > 1:
            raise TypeError(f"execute: found {' and '.join(told + ['plan'] * (plan is not None))}, expected one of them")
        kind = told[0] if told else "moments, pressures, inputs or plan"
        values, values_go_on = _way_text(given[kind] if told else (), kind)
        bases, bases_go_on = _way_text(() if base is None else base, "base")
        lengths = [] if insertion is None else insertion.split(";") if isinstance(insertion, str) else entries(insertion, "insertion")
        insertions = "; ".join(_input_text(v, f"insertion[{i}]") for i, v in enumerate(lengths))
        along = values_go_on or bases_go_on or len(lengths) > 1 or is_list(insertion)
        path, text = self._open().execute(kind, values, _json_of(plan, "plan"), _json_of(start, "start"), along, insertions, bases)
        return self._known((Trajectory if path else Execution).from_json(text))

    def describe(self) -> Description:
        """`tendril describe`: the assembled program, and what was left out of it and why. Plans nothing."""
        return Description.from_json(self._open().describe())

    @overload
    def study(self, *, jobs: int = 1, output: File | None = None, figure: File | None = None, movie: File | None = None,
              shard: None = None, merge: bool = False, progress: Progress = False,
              start_method: str | None = None) -> Study: ...

    @overload
    def study(self, *, jobs: int = 1, output: File, shard: tuple[int, int], progress: Progress = False,
              start_method: str | None = None) -> Study | None: ...

    def study(self, *, jobs: int = 1, output: File | None = None, figure: File | None = None, movie: File | None = None,
              shard: tuple[int, int] | None = None, merge: bool = False, progress: Progress = False,
              start_method: str | None = None) -> Study | None:
        """`tendril study`: the sweeps that the scene declares; here, or with jobs above 1 in so many processes. With `output`, a
        directory, finished cases are kept there, tables and figures are written, and an interrupted study goes on.

        `figure`, `movie`: files of their own. `shard`: (i, n), only the i-th of n parts, which gives no Study unless n is 1;
        `merge` joins the parts in `output`. `progress`, `start_method`: as for plan_many().
        """
        from ._study import run_study

        text = run_study(self, jobs, (path_of(output, "output"), path_of(figure, "figure"), path_of(movie, "movie")), shard, merge, progress, start_method)
        return None if text is None else Study.from_json(text)

    def sensitivity(self, *keys: str, held: bool = False, moments: Iterable[Any] | None = None,
                    plan: Earlier | None = None) -> Sensitivities:
        """`tendril sensitivity`: derivatives of the scene's plan by its numbers, SI, by default all of them.

        `held`: of what the robot does under the plan's moments, instead of another plan; "moments[0]" is a key then.
        `moments` (N m): of what it does under these, instead. `plan`: an earlier result of this scene, planned or executed,
        which is differentiated as it is; of a trajectory one of its steps. Raises ValueError where there are none, in words.
        """
        for key in keys:
            if not isinstance(key, str):
                raise TypeError(f"keys: found {key!r}, expected the path of a number such as 'obstacle[0].radius'")
            unicode(key, "keys")
        _refuse(held and moments is not None, "held", "moments that are given are held anyway, expected one of both")
        _refuse(plan is not None and moments is not None, "plan", "its moments are those that count, expected one of both")
        text = "" if moments is None else _inputs_text(moments, "moments")
        result = Sensitivities.from_json(self._open().sensitivity(keys, bool(held), text, _json_of(plan, "plan")))
        if "trouble" in result:
            raise ValueError(f"there are no derivatives: {result['trouble']}")
        return result

    def calibrate(self, *, output: File | None = None, figure: File | None = None) -> Calibration:
        """`tendril calibrate`: numbers of the rod from the measured shapes that the scene names. With `output`, a
        directory, figures and a fragment that scenes include are written there; `figure` is a file of its own.
        """
        text, notes = self._open().calibrate(path_of(output, "output"), path_of(figure, "figure"))
        self._warn(notes)
        return Calibration.from_json(text)

    def live(self, *, port: int = 0, browser: bool = True, ready: Callable[[str], Any] | None = None) -> None:
        """`tendril live`: a page on this machine where target, obstacles and base can be dragged. Ends with Ctrl-C.

        `port`: of the loopback interface, 0 for any that is free. `browser`: opens the page where there is a display.
        `ready`: called with the address, instead of printing it.
        """
        number = whole_number(port, "port", 0, 65535)
        try:
            _native.live(self._source(), number, bool(browser), ready or (lambda address: print(f"live at {address}", flush=True)))
        except KeyboardInterrupt:
            pass

    def problem(self) -> Problem:
        """The assembled problem, for loops: `problem.follow((0.097, 0.01))`."""
        return Problem(self)


class Problem:
    """A scene made ready to plan again and again for other targets.

    After each `plan()` and `follow()` its properties tell of the newest plan: `status`, `solved`, `message`,
    `objective`, `target_error`, `tip`, `moments`, `coordinates`, `backbone`, `contacts`. Arrays are copies, since the
    next step writes over what they are read from. `result()` is the whole plan.
    """

    def __init__(self, scene: Scene) -> None:
        self._native = _native.Problem(scene._source())
        #: Leads the tip on: `follow(position=None, angle=None, turns=None)`. Newton from the plan before where that
        #: does, else a full plan; the first call plans.
        self.follow = self._native.follow

    def plan(self, *, start: Earlier | None = None) -> Plan:
        """Plans for the target set last."""
        return Plan.from_json(self._native.plan(_json_of(start, "start")))

    def set_target(self, position: Any = None, angle: Any = None, turns: int | None = None) -> None:
        """Asks for another pose from now on."""
        self._native.set_target(position, angle, turns)

    def result(self) -> Plan:
        """The newest plan as a result of its own."""
        return Plan.from_json(self._native.json())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._native, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(name for name in dir(self._native) if not name.startswith("_"))})


def _steps(key: str) -> list[str]:
    """ "rod.actuator[0].limit" as ["rod", "actuator", "0", "limit"]."""
    if not isinstance(key, str):
        raise TypeError(f"key: found {key!r}, expected text such as \"contact.max_force\"")
    steps = [step for step in _STEP.split(unicode(key, "key")) if step]
    if not steps:
        raise KeyError(f"found the key {key!r}, expected one such as \"contact.max_force\"")
    return steps


def _leaves(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and value:
        for inner, item in value.items():
            yield from _leaves(f"{key}.{inner}", item)
    else:
        yield key, value


def _paths(path: str, node: Any) -> Iterator[str]:
    if path:
        yield path
    if isinstance(node, dict):
        for key, item in node.items():
            yield from _paths(f"{path}.{key}" if path else key, item)
    elif isinstance(node, list) and any(isinstance(item, dict) for item in node):
        for i, item in enumerate(node):
            yield from _paths(f"{path}[{i}]", item)


def path_of(file: File | None, name: str) -> str | None:
    return None if file is None else os.path.abspath(file_path(file, name))


def _mapping(value: Mapping[str, Any] | None, name: str) -> Mapping[str, Any]:
    if value is not None and not isinstance(value, Mapping):
        raise TypeError(f"{name}: found {value!r}, expected a dictionary")
    return value or {}


def _refuse(condition: bool, name: str, why: str) -> None:
    if condition:
        raise ValueError(f"{name}: {why}")


def _inputs_text(values: Any, name: str) -> str:
    return ", ".join(_input_text(v, f"{name}[{i}]") for i, v in enumerate(entries(values, name)))


def _way_text(values: Any, name: str) -> tuple[str, bool]:
    """One list, or several, one behind the other; and whether they are several."""
    lists = values.split(";") if isinstance(values, str) else entries(values, name)
    if isinstance(values, str) and len(lists) > 1 or any(is_list(entry) for entry in lists):
        return "; ".join(_inputs_text(entry, f"{name}[{i}]") for i, entry in enumerate(lists)), True
    return _inputs_text(values if isinstance(values, str) else lists, name), False


def _input_text(value: Any, name: str) -> str:
    number = plain(value, name)
    return number if isinstance(number, str) else repr(number)


def _json_of(result: Earlier | None, name: str) -> str | None:
    """An earlier result as JSON: a result, its dictionary, or its file."""
    if result is None:
        return None
    if isinstance(result, Result):
        return result.to_json()
    if isinstance(result, Mapping):
        return json_text(result, name)
    if isinstance(result, (str, os.PathLike)):
        with open(result, encoding="utf-8") as stream:
            return stream.read()
    raise TypeError(f"{name}: found {type(result).__name__}, expected a result, its dictionary, or its file")
