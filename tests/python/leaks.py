"""leaks.py SCENES [PLANS]: makes PLANS plans (100000), by Scene.plan() and Problem.plan(), with terms of plugins and of Python, under
a limit of memory, and fails where what is allocated grows with them."""

import ctypes
import gc
import itertools
import os
import pathlib
import resource
import sys
import time

if os.environ.get("PYTHONMALLOC") != "malloc":  # so that the C library counts Python's own objects, too
    os.execve(sys.executable, [sys.executable, "-B", *sys.argv], {**os.environ, "PYTHONMALLOC": "malloc"})

import tendril

BYTES_PER_PLAN = 8.0  # less than anything that can be forgotten once a plan
SETTLING = 128 << 10  # bytes that the allocator keeps aside in the first thousands of plans, and no more after them
ROOM = 64 << 20  # bytes beyond what is there after the first plans


class Mallinfo(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks",
                                                     "fordblks", "keepcost")]


mallinfo = ctypes.CDLL(None).mallinfo2
mallinfo.restype = Mallinfo


def allocated():
    gc.collect()
    found = mallinfo()
    return found.uordblks + found.hblkhd


def statm(column):
    return int(pathlib.Path("/proc/self/statm").read_text().split()[column]) * resource.getpagesize()


@tendril.objective("own_target", reads=["tip_position", "target"])
def own_target(x):
    return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]


def ways(scenes):
    """Calls that each make one plan, for ever: one in contact, by a term of a plugin, and one that is free, by a term of Python."""
    braced, free = (tendril.load(scenes / f"{name}.toml").copy({"search.effort": "fast"}) for name in ("brace", "free"))
    first, *others = free["objective"]
    own = free.copy({"objective": [{**first, "plugin": "own_target"}, *others]})
    problems = [scene.problem() for scene in (braced, own)]
    for i in itertools.count():
        place = (0.097, 0.02 - 1e-5 * (i % 100))
        for scene in (braced, own):
            yield lambda scene=scene: scene.copy({"target.position": place}).plan()
        for problem in 4 * problems:
            problem.follow(place)
            assert problem.solved and len(problem.moments) == 1 and len(problem.backbone) > 1 and len(problem.contacts) < 2
            yield problem.plan


def main():
    scenes, plans = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 100_000
    calls = ways(scenes)

    def make(count):
        for call in itertools.islice(calls, count):
            plan = call()
            assert plan.solved and plan.backbone.shape[1] == 5 and plan.row()

    make(400)
    before, resident, begin = allocated(), statm(1), time.monotonic()
    resource.setrlimit(resource.RLIMIT_AS, (statm(0) + ROOM,) * 2)
    for part in range(10):
        make(plans // 10)
        print(f"{(part + 1) * (plans // 10)} plans, {time.monotonic() - begin:.0f} s: allocated {allocated() / 2**20:.2f} MiB "
              f"({(allocated() - before) / ((part + 1) * (plans // 10)):+.2f} bytes a plan), resident {statm(1) / 2**20:.1f} MiB "
              f"(before {resident / 2**20:.1f} MiB)", flush=True)
    growth, most = allocated() - before, BYTES_PER_PLAN * plans + SETTLING
    if growth > most:
        sys.exit(f"{growth} bytes more after {plans} plans, expected at most {most:.0f}")


main()
