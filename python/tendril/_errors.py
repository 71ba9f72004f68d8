"""What tendril raises."""

from __future__ import annotations

import re

_PLACE = re.compile(r"(?P<file>.*?):(?P<line>\d+):(?P<column>\d+): ", re.DOTALL)
_SUGGESTION = re.compile(r"did you mean '?\"?(?P<name>[^'\"?]+)")


class Error(ValueError):
    """Input that cannot be used. The message says what was found, what was expected, and where.

    `file`, `line`, `column` are the place in a scene or a table, None where the message names a setting instead;
    `suggestion` is the nearest valid name, None where nothing is near.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        place = _PLACE.match(message)
        self.file: str | None = place["file"] if place else None
        self.line: int | None = int(place["line"]) if place else None
        self.column: int | None = int(place["column"]) if place else None
        near = _SUGGESTION.search(message)
        self.suggestion: str | None = near["name"] if near else None
