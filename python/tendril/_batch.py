"""Many scenes at once, each in a process of its own kind."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import sys
from collections.abc import Callable, Iterable
from typing import Any

from ._results import Result
from ._scene import Scene


class Failure(Result):
    """What stands in the place of a result where there is none: a scene that was refused, a process that died."""

    def __init__(self, document: Any) -> None:
        super().__init__({"schema": 1, "status": "failed", **document})


def plan_many(scenes: Iterable[Scene], *, jobs: int = 1, verify: bool = False,
              progress: bool | Callable[[int, int], Any] = False, start_method: str | None = None) -> list[Result]:
    """Plans every scene, `jobs` at a time, each process taking one after the other. Results stand in the order of the
    scenes; a scene that is refused, or whose process dies, is a Failure and spoils no other.

    `progress`: called with how many are finished and how many there are, or True for a bar (of tqdm, if it is there).
    `start_method`: of multiprocessing; None: what is usual on this system.
    """
    waiting = list(scenes)
    for i, scene in enumerate(waiting):
        if not isinstance(scene, Scene):
            raise TypeError(f"scenes[{i}]: found {type(scene).__name__}, expected a Scene")
    if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
        raise ValueError(f"jobs: found {jobs!r}, expected a whole number from 1 on")
    report = _reporter(progress, len(waiting))
    results: list[Any] = [None] * len(waiting)
    context: Any = multiprocessing.get_context(start_method)
    workers = [_Worker(context, verify) for _ in range(min(jobs, len(waiting)))]
    try:
        next_one, finished = 0, 0
        while finished < len(waiting):
            for worker in workers:
                if worker.index is None and next_one < len(waiting):
                    worker.give(next_one, waiting[next_one])
                    next_one += 1
            busy = [worker for worker in workers if worker.index is not None]
            for pipe in multiprocessing.connection.wait([worker.pipe for worker in busy]):
                worker = next(w for w in busy if w.pipe is pipe)
                index = worker.index
                assert index is not None  # it is busy
                results[index] = worker.take(waiting[index])
                finished += 1
                report(finished)
    finally:
        for worker in workers:
            worker.end()
    return results


class _Worker:
    """A process that plans what it is given, and is replaced when it dies."""

    def __init__(self, context: Any, verify: bool) -> None:
        self._context, self._verify = context, verify
        self.index: int | None = None
        self._begin()

    def _begin(self) -> None:
        self.pipe, theirs = self._context.Pipe()
        self._process = self._context.Process(target=_work, args=(theirs, self._verify), daemon=True)
        self._process.start()
        theirs.close()

    def give(self, index: int, scene: Scene) -> None:
        self.index = index
        try:
            self.pipe.send(scene)
        except (BrokenPipeError, ConnectionResetError):
            pass  # take() tells that it has died

    def take(self, scene: Scene) -> Result:
        self.index = None
        try:
            return self.pipe.recv()
        except (EOFError, ConnectionResetError):
            self._process.join()
            code = self._process.exitcode
            self.pipe.close()
            self._begin()
            died = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
            return Failure({"scene": scene._file, "message": f"its process was ended {died}"})

    def end(self) -> None:
        if self.index is not None:
            self._process.terminate()
        try:
            self.pipe.send(None)  # closing is not enough: processes made later hold this end as well
        except (BrokenPipeError, ConnectionResetError):
            pass
        self._process.join()
        self.pipe.close()


def _work(pipe: Any, verify: bool) -> None:
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that gives the work ends it
    while True:
        try:
            scene = pipe.recv()
        except EOFError:
            return
        if scene is None:
            return
        try:
            result: Result = scene.plan(verify=verify)
        except MemoryError:
            result = Failure({"scene": scene._file, "message": "out of memory"})
        except Exception as error:
            result = Failure({"scene": scene._file, "message": str(error)})
        try:
            pipe.send(result)
        except (BrokenPipeError, ConnectionResetError):
            return


def _reporter(progress: bool | Callable[[int, int], Any], total: int) -> Callable[[int], Any]:
    if not isinstance(progress, bool):
        call = progress
        return lambda finished: call(finished, total)
    if not progress:
        return lambda finished: None
    try:
        from tqdm.auto import tqdm

        bar = tqdm(total=total)
        return lambda finished: bar.update()
    except ImportError:
        return lambda finished: print(f"\r{finished} of {total}", end="" if finished < total else "\n", file=sys.stderr)
