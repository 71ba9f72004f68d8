"""Plans poses, trajectories and grasps for soft continuum robots that use contact.

    import tendril

    scene = tendril.load("brace.toml")
    plan = scene.plan()
    plan.tip, plan.moments, plan.contacts
    plan.plot()

Numbers are SI; text has a unit ("2.5 N mm"); quantities of pint and arrays of numpy do as well.
"""

from __future__ import annotations

from ._batch import Failure, plan_many
from ._command import command, plugins
from ._components import Option, Quantities, check, coordinates, objective, obstacle, unregister
from ._errors import Error
from ._native import version as __version__
from ._results import (
    Calibration, Contact, Description, Estimate, Execution, Finger, FrictionState, Plan, Result, Sensitivities, SequenceEstimate, Study,
    Tip, Trajectory,
)
from ._scene import Problem, Scene, load

__all__ = [
    "Calibration", "Contact", "Description", "Error", "Estimate", "Execution", "Failure", "Finger", "FrictionState", "Option", "Plan",
    "Problem", "Quantities",
    "Result", "Scene", "Sensitivities", "SequenceEstimate", "Study", "Tip", "Trajectory", "__version__", "check", "command", "coordinates", "load", "objective",
    "obstacle", "plan_many", "plugins", "unregister",
]
