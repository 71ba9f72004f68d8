"""A study: its cases here, or in processes, and what is made of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _native
from ._pool import Died, Progress, reporting, run_pool
from ._values import whole_number

if TYPE_CHECKING:
    from ._scene import Scene


class _Cases:
    """Answers the cases of a scene's study; opens it once in each process."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._native: Any = None

    def __call__(self, index: int) -> str:
        if self._native is None:
            self._native = _native.StudyCases(self._scene._source())
        return self._native.answer(index)

    def __getstate__(self) -> dict[str, Any]:
        return {"_scene": self._scene, "_native": None}


def run_study(scene: Scene, jobs: int, places: tuple[str | None, str | None, str | None], shard: tuple[int, int] | None,
              merge: bool, progress: Progress, start_method: str | None) -> str | None:
    """The JSON of the study; None: the cases of a shard are finished."""
    jobs = whole_number(jobs, "jobs")
    if shard is not None and (not isinstance(shard, tuple) or len(shard) != 2):
        raise TypeError(f"shard: found {shard!r}, expected (i, n), the i-th of n parts")
    part = "" if shard is None else f"{whole_number(shard[0], 'shard[0]')}/{whole_number(shard[1], 'shard[1]')}"
    study = _native.Study(scene._source(), *places, part, bool(merge))
    scene._warn(study.warnings)
    waiting = study.waiting
    total = study.finished + len(waiting)
    with reporting(progress, total) as report:
        def take(at: int, answer: Any) -> None:
            if isinstance(answer, Died):
                study.lost(waiting[at], str(answer))
            else:
                study.take(waiting[at], answer)
            report(study.finished, total)

        cases = _Cases(scene)
        if jobs == 1:
            for at, index in enumerate(waiting):
                take(at, cases(index))
        else:
            run_pool(cases, waiting, jobs, start_method, take)
    if shard is not None and not study.one_shard:
        return None
    text, notes = study.finish()
    scene._warn(notes)
    return text

