"""Many scenes at once, each in a process of its own kind."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any

from ._pool import Died, Progress, reporting, run_pool
from ._results import Result
from ._scene import Scene
from ._values import each, whole_number


class Failure(Result):
    """What stands in the place of a result where there is none: a scene that was refused, a process that died."""

    def __init__(self, document: Any) -> None:
        super().__init__({"schema": 1, "status": "failed", **document})


def plan_many(scenes: Iterable[Scene], *, jobs: int = 1, verify: bool = False, progress: Progress = False,
              start_method: str | None = None) -> list[Result]:
    """Plans every scene, `jobs` at a time, each process taking one after the other. Results stand in the order of the
    scenes; a scene that is refused, or whose process dies twice, is a Failure and spoils no other.

    `progress`: called with how many are finished and how many there are, or True for a bar (of tqdm, if it is there).
    `start_method`: of multiprocessing; None: what is usual on this system.
    """
    if isinstance(scenes, Scene):
        raise TypeError("scenes: found a Scene, expected a list of them")
    waiting = each(scenes, "scenes")
    for i, scene in enumerate(waiting):
        if not isinstance(scene, Scene):
            raise TypeError(f"scenes[{i}]: found {type(scene).__name__}, expected a Scene")
    jobs = whole_number(jobs, "jobs")
    results: list[Any] = [None] * len(waiting)
    with reporting(progress, len(waiting)) as report:
        def take(index: int, answer: Any) -> None:
            if isinstance(answer, Died):
                answer = Failure({"scene": waiting[index]._file, "message": str(answer)})
            results[index] = answer
            report(sum(result is not None for result in results), len(waiting))

        run_pool(functools.partial(_planned, verify=verify), waiting, jobs, start_method, take)
    return results


def _planned(scene: Scene, verify: bool) -> Result:
    try:
        return scene.plan(verify=verify)
    except MemoryError:
        return Failure({"scene": scene._file, "message": "out of memory"})
    except Exception as error:
        return Failure({"scene": scene._file, "message": str(error)})
