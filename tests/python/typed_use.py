"""Never run: what a user writes has the types that a checker is told of."""

from typing import Any

import numpy as np
import numpy.typing as npt

import tendril

scene: tendril.Scene = tendril.load("brace.toml")
changed: tendril.Scene = scene.copy({"contact.max_force": "2 N"}, title="other")
plan = scene.plan(verify=True)
if isinstance(plan, tendril.Plan):
    moments: npt.NDArray[np.float64] = plan.moments
    force: float = plan.contacts[0].force
    error: float | None = plan.target_error
steps: list[tendril.Plan] = scene.trajectory().steps
problem: tendril.Problem = scene.problem()
problem.follow((0.097, 0.02))
angle: float = problem.tip[2]
study: tendril.Study = scene.study(jobs=2, output="sizes", progress=True)
part: tendril.Study | None = scene.study(output="sizes", shard=(1, 2))
matrix: npt.NDArray[np.float64] = scene.sensitivity("rod.length", moments=["2 N mm"]).matrix
study.view("study.html")
scene.live(port=8000, ready=lambda address: None)
keys: str = tendril.command("reference", "keys")
results: list[tendril.Result] = tendril.plan_many([scene, changed], jobs=2)
found = scene.estimate()
forces: npt.NDArray[np.float64] | None = found.forces if isinstance(found, tendril.SequenceEstimate) else None
try:
    scene.estimate()
except tendril.Error as refused:
    line: int | None = refused.line


@tendril.objective("level_tip", reads=["tip_angle"], options={"angle": tendril.Option(0.0, unit="rad"), "strict": False})
def level_tip(x: tendril.Quantities, angle: float, strict: bool) -> Any:
    return [x.tip.angle - angle]


def findings() -> list[str]:
    return tendril.check("level_tip", angle=0.1)
