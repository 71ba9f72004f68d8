"""The command that belongs to the library in use."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from . import _native
from ._errors import Error
from ._values import each, file_path


def command_path() -> str:
    """The file of the command."""
    path = _native.command_path()
    if not os.access(path, os.X_OK):
        raise FileNotFoundError(f"the command is not beside the library: {path}")
    return path


def command(*arguments: str | os.PathLike[str], text: str | None = None) -> str:
    """Runs the command in a process of its own: `command("new", "objective", "my_term")` writes a plugin project,
    `command("reference", "keys")` gives all scene keys. Returns what it prints; `text` is its standard input.

    Raises Error with its message where it refuses its input. It knows no component of this process.
    """
    import signal
    import subprocess

    words = [file_path(argument, f"arguments[{i}]") for i, argument in enumerate(arguments)]
    process = subprocess.Popen([command_path(), *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        output, errors = process.communicate(text)
    except BaseException:
        # Ctrl-C reaches the command as well where both share a terminal; elsewhere it has to be told.
        process.send_signal(signal.SIGINT)
        process.communicate()
        raise
    if process.returncode not in (0, 1) or (process.returncode == 1 and not output):
        message = errors.strip().splitlines()[-1] if errors.strip() else f"the command ended with {process.returncode}"
        raise Error(message.removeprefix("tendril: "))
    return output


def plugins(plugin_directories: Sequence[str | os.PathLike[str]] = ()) -> dict[str, Any]:
    """`tendril plugins --json`: what is loadable, its options, what was refused and why. Each is tried in a process of its
    own, so that one which cannot be loaded does no harm here.
    """
    import json

    words = [word for directory in each(plugin_directories, "plugin_directories") for word in ("--plugin-dir", file_path(directory, "plugin_directories"))]
    return json.loads(command("plugins", "--json", *words))
