"""The command that belongs to the library in use."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _native
from ._components import used_in
from ._errors import Error
from ._results import Calibration, Sensitivities, Study
from ._values import inline

if TYPE_CHECKING:
    from ._scene import Scene


def command_path() -> str:
    """The file of the command."""
    path = _native.command_path()
    if not os.access(path, os.X_OK):
        raise FileNotFoundError(f"the command is not beside the library: {path}")
    return path


def run(arguments: Sequence[str], *, text: str | None = None, directory: str | None = None) -> str:
    """Standard output of the command. Raises Error where it refuses its input; what it says goes on as it comes."""
    process = subprocess.Popen([command_path(), *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, encoding="utf-8", cwd=directory)
    try:
        output, errors = process.communicate(text)
    except BaseException:
        # Ctrl-C reaches the command as well where both share a terminal; elsewhere it has to be told.
        process.send_signal(signal.SIGINT)
        process.communicate()
        raise
    if process.returncode not in (0, 1) or not output:
        message = errors.strip().splitlines()[-1] if errors.strip() else f"the command ended with {process.returncode}"
        raise Error(message.removeprefix("tendril: "))
    return output


def study(scene: Scene, jobs: int, output: str | os.PathLike[str] | None) -> Study:
    if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
        raise ValueError(f"jobs: found {jobs!r}, expected a whole number from 1 on")
    arguments = ["--json", "--jobs", str(jobs)]
    if output is not None:
        arguments += ["--output", os.path.abspath(output)]
    return Study.from_json(_run_on(scene, "study", arguments))


def sensitivity(scene: Scene, keys: Sequence[str], held: bool, moments: Sequence[float] | None = None) -> Sensitivities:
    """`tendril sensitivity` of a scene, or of what comes of it under `moments` (N m)."""
    for key in keys:
        if not isinstance(key, str):
            raise TypeError(f"keys: found {key!r}, expected the path of a number such as 'obstacle[0].radius'")
    kind = ["--held"] if held and not moments else []
    if moments:
        kind = ["--moments=" + ",".join(repr(float(moment)) for moment in moments)]
    result = Sensitivities.from_json(_run_on(scene, "sensitivity", ["--json", *kind], keys))
    if "trouble" in result:
        raise ValueError(f"there are no derivatives: {result['trouble']}")
    return result


def calibrate(scene: Scene, output: str | os.PathLike[str] | None) -> Calibration:
    """`tendril calibrate` of a scene."""
    return Calibration.from_json(_run_on(
        scene, "calibrate", ["--json", *(["--output", os.path.abspath(output)] if output is not None else [])]))


def _run_on(scene: Scene, command: str, arguments: Sequence[str], words: Sequence[str] = ()) -> str:
    """Standard output of a command on a scene, whose file may have been changed since it was read."""
    own = used_in(scene._tables())
    if own:
        raise ValueError(f"{command}: the scene names {own[0]} of this process, which the command's processes do not know; plan() "
                         "and plan_many() do")
    arguments = list(arguments)
    for directory in scene._plugin_directories:
        arguments += ["--plugin-dir", os.path.abspath(directory)]
    if _unchanged(scene):
        settings = [word for key, value, is_text, _ in scene._settings
                    for word in ("--set", f"{key}={inline(value, key) if is_text else value}")]
        return run([command, scene._file, *words, *arguments, *settings])
    folder = os.path.dirname(scene._file) or None
    return run([command, "-", *words, *arguments], text=scene.to_toml(), directory=folder)


def _unchanged(scene: Scene) -> bool:
    """Whether the scene's file still says what the scene was read from."""
    try:
        with open(scene._file, encoding="utf-8", newline="") as stream:
            return stream.read() == scene._text
    except (OSError, UnicodeDecodeError):
        return False


def plugins(plugin_directories: Sequence[str | os.PathLike[str]] = ()) -> dict[str, Any]:
    """`tendril plugins --json`: what is loadable, its options, what was refused and why."""
    import json

    words = [word for directory in plugin_directories for word in ("--plugin-dir", os.fspath(directory))]
    return json.loads(run(["plugins", "--json", *words]))
