"""Processes that answer one question after the other, and bars that say how far they are."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Union

Progress = Union[bool, Callable[[int, int], Any]]
_ATTEMPTS = 2  # as the command: something outside may have ended the first process


class Died(str):
    """How a process ended that had no answer."""


class _Raised:
    """What the work raised in its process."""

    def __init__(self, error: Exception) -> None:
        self.error = error


def run_pool(work: Callable[[Any], Any], questions: Sequence[Any], jobs: int, start_method: str | None,
             take: Callable[[int, Any], None]) -> None:
    """Gives each question to `work` in one of `jobs` processes, and its answer, or Died, to `take` as it comes. What the work
    raises is raised here.
    """
    import multiprocessing
    import multiprocessing.connection

    if start_method not in (None, *multiprocessing.get_all_start_methods()):
        raise ValueError(f"start_method: found {start_method!r}, expected one of {multiprocessing.get_all_start_methods()}")
    context: Any = multiprocessing.get_context(start_method)
    waiting = list(enumerate(questions))[::-1]
    tries = [0] * len(questions)
    workers = [_Worker(context, work) for _ in range(min(jobs, len(questions)))]
    try:
        while waiting or any(worker.busy for worker in workers):
            for worker in workers:
                if not worker.busy and waiting:
                    worker.give(*waiting.pop())
            pipes = {worker.pipe: worker for worker in workers if worker.busy}
            for pipe in multiprocessing.connection.wait(list(pipes)):
                worker = pipes[pipe]
                index = worker.index
                answer = worker.take()
                if isinstance(answer, _Raised):
                    raise answer.error
                tries[index] += 1
                if isinstance(answer, Died) and tries[index] < _ATTEMPTS:
                    waiting.append((index, questions[index]))
                else:
                    take(index, answer)
    finally:
        for worker in workers:
            worker.end()


class _Worker:
    """A process that works on what it is given, and is replaced when it dies."""

    def __init__(self, context: Any, work: Callable[[Any], Any]) -> None:
        self._context, self._work = context, work
        self.index, self.busy = 0, False
        self._begin()

    def _begin(self) -> None:
        self.pipe, theirs = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(theirs, self._work), daemon=True)
        self._process.start()
        theirs.close()

    def give(self, index: int, question: Any) -> None:
        self.index, self.busy = index, True
        try:
            self.pipe.send(question)
        except (BrokenPipeError, ConnectionResetError):
            pass  # take() tells that it has died

    def take(self) -> Any:
        self.busy = False
        try:
            return self.pipe.recv()
        except (EOFError, ConnectionResetError):
            self._process.join()
            code = self._process.exitcode
            self.pipe.close()
            self._begin()
            died = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
            return Died(f"its process was ended {died}")

    def end(self) -> None:
        if self.busy:
            self._process.terminate()
        try:
            self.pipe.send(None)  # closing is not enough: processes made later hold this end as well
        except (BrokenPipeError, ConnectionResetError):
            pass
        self._process.join()
        self.pipe.close()


def _serve(pipe: Any, work: Callable[[Any], Any]) -> None:
    import os
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that gives the work ends it
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # processes are the parallelism here
    while True:
        try:
            question = pipe.recv()
        except EOFError:
            return
        if question is None:
            return
        answer: Any
        try:
            answer = work(question)
        except Exception as error:
            answer = _Raised(error)
        try:
            pipe.send(answer)
        except (BrokenPipeError, ConnectionResetError):
            return


@contextlib.contextmanager
def reporting(progress: Progress, total: int = 0) -> Iterator[Callable[[int, int], Any]]:
    """What is called with how many are finished and how many there are, 0 where nobody knows; shows a bar where it is asked for.
    `total`: as far as it is known beforehand.
    """
    if not isinstance(progress, bool):
        if not callable(progress):
            raise TypeError(f"progress: found {progress!r}, expected True, False or a function of two numbers")
        yield progress
        return
    if not progress:
        yield lambda finished, count: None
        return
    bar = _bar(total)
    try:
        yield bar.show
    finally:
        bar.close()


class _Printed:
    """A bar where tqdm is not there."""

    def show(self, finished: int, total: int) -> None:
        print(f"\r{finished} of {total}" if total else f"\r{finished}", end="", file=sys.stderr)

    def close(self) -> None:
        print(file=sys.stderr)


class _Drawn:
    def __init__(self, tqdm: Any, total: int) -> None:
        self._bar = tqdm(total=total or None)

    def show(self, finished: int, total: int) -> None:
        self._bar.total = total or None
        self._bar.update(finished - self._bar.n)

    def close(self) -> None:
        self._bar.close()


def _bar(total: int) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _Printed()
    return _Drawn(tqdm, total)
