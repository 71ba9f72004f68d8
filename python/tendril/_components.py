"""Objective terms, coordinate models and obstacle shapes that are written in Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, NoReturn, TypeVar, Union

from . import _native
from ._values import each, number, whole_number

#: What a quantity is: a plain number, or one that carries derivatives. Arithmetic and numpy's functions take both.
Number = Any
OptionDefault = Union[bool, int, float, str, Sequence[float], None]
T = TypeVar("T")


class BackbonePoint(NamedTuple):
    """A point of the rod: x and y in units of its length, angle in rad, curvature times the length, and the strain of a
    rod that stretches, else 0.
    """

    x: Number
    y: Number
    angle: Number
    curvature: Number
    strain: Number


class ContactPoint(NamedTuple):
    """A planned contact: lengths in units of the rod's, the normal out of the obstacle, the force along it in units of
    EI/L^2.
    """

    x: Number
    y: Number
    gap: Number
    normal_x: Number
    normal_y: Number
    force: Number
    arc_length: Number
    reference_x: Number
    reference_y: Number


class TipDeviation(NamedTuple):
    """Where the tip goes, to first order, with one standard deviation of what is uncertain, in units of the rod's length."""

    x: Number
    y: Number


class TargetPose(NamedTuple):
    """The pose asked for: position in units of the rod's length, angle in rad; None where nothing is asked."""

    position: tuple[float, float] | None
    angle: float | None


class Quantities(NamedTuple):
    """What a term sees, dimensionless: moments in units of EI/L, the bending energy likewise; of tendons, in the order
    of the actuators, tensions in units of EI/L^2 and what they are shorter by in units of the rod's length. The
    insertion is how much of the rod is out of its port, in units of its length: 1 of one that is not drawn in or out.
    The squares of the deviations of the tip add up to its variance under the error bars of the scene.
    """

    tip: BackbonePoint
    samples: tuple[BackbonePoint, ...]
    contacts: tuple[ContactPoint, ...]
    moments: tuple[Number, ...]
    tensions: tuple[Number, ...]
    shortenings: tuple[Number, ...]
    tip_deviations: tuple[TipDeviation, ...]
    bending_energy: Number
    insertion: Number
    palm_distance: Number
    target: TargetPose


class NotRead:
    """Stands where a term sees a quantity that it did not ask for; whatever is done with it says so."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __repr__(self) -> str:
        return f'"{self._name}", which is not among its `reads`'

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        if self._name == "samples":
            raise TypeError("the curvature and the strain of the tip are not read; samples=[1.0] asks for the point at the rod's end")
        raise TypeError(f"the term uses a quantity that it does not read; expected \"{self._name}\" among its `reads`")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = _refuse
    __rpow__ = __neg__ = __pos__ = __abs__ = __float__ = __bool__ = __lt__ = __le__ = __gt__ = __ge__ = _refuse
    __array_ufunc__ = _refuse


NOT_READ = {name: NotRead(name) for name in (
    "tip_position", "tip_angle", "samples", "contact_point", "contact_gap", "contact_normal", "contact_force",
    "contact_arc_length", "moments", "tensions", "shortenings", "bending_energy", "insertion",
    "palm_distance", "tip_deviations")}


class Option(NamedTuple):
    """An option that a scene may set, beside its default. A number with a `unit`, an SI unit ("m", "rad", "1/m", "N",
    "N m", "N m^2", "Pa"), may be text with a unit in the scene and arrives dimensionless. None: a scene has to say it.
    """

    default: OptionDefault = None
    unit: str = ""
    description: str = ""
    minimum: float = float("-inf")
    maximum: float = float("inf")


Options = Mapping[str, Union[Option, OptionDefault]]

_registered: dict[tuple[str, str], Any] = {}


def objective(name: str, *, reads: Iterable[str] = (), samples: Iterable[float] = (), lower_bound: float = 0.0,
              options: Options | None = None) -> Callable[[T], T]:
    """Makes the function below it an objective term that scenes name as `plugin = "name"`.

    The function takes the Quantities, and the options by name. It returns a number, which is added to the cost, or a
    list of numbers, whose squares are. `reads` names what it looks at: tip_position, tip_angle, bending_energy, moments,
    tensions, shortenings, contact_point, contact_gap, contact_normal, contact_force, contact_arc_length, insertion,
    palm_distance, tip_deviations, target; `samples` asks for points of the rod at these arc lengths, from 0 to 1. `lower_bound`: the cost is never below it, -math.inf where
    there is none. Derivatives come by themselves, through arithmetic and numpy's functions; math's do not take the
    numbers.
    """
    def register(function: T) -> T:
        _callable(function, "objective")
        _register("objective", name, _native.objective(name, _about(function), function, names, places, bound, schema))
        return function

    _texts([name], "name")
    names, schema = _texts(each(reads, "reads"), "reads"), _options(options)
    places = [number(s, f"samples[{i}]", 0.0, 1.0) for i, s in enumerate(each(samples, "samples"))]
    bound = number(lower_bound, "lower_bound")
    return register


def coordinates(name: str, *, functions: int | Callable[..., int], breaks: Any = (), subdivision: Any = (1.0,),
                names: Any = (), options: Options | None = None) -> Callable[[T], T]:
    """Makes the function below it a coordinate model, a local basis that scenes name as `plugin = "name"`.

    The function takes an array of places from 0 to 1, and the options by name, and returns three arrays, a row per
    place and a column per basis function: values (0 at the place 0), first and second derivatives. `functions` is their number,
    `breaks` are places of reduced smoothness, `subdivision` the parts into which a stretch is cut, `names` those of the
    coordinates; each may be a function of the options.
    """
    def register(function: T) -> T:
        _callable(function, "coordinates")
        _register("coordinates", name, _native.coordinates(name, _about(function), function, functions, breaks, subdivision, names,
                                                           schema))
        return function

    _texts([name], "name")
    schema = _options(options)
    if not callable(functions):
        whole_number(functions, "functions")
    return register


def obstacle(name: str, *, options: Options | None = None) -> Callable[[type], type]:
    """Makes the class below it an obstacle that scenes name as `shape = "name"`.

    An object is made with the options by name. All lengths are in units of the rod's. It has

    - `at(x, y)`: (signed distance, unit normal (x, y) out of the body, curvature of the level set there, how fast that
      changes along the turned normal), everywhere
    - `core_distance(x, y)`: to the core that is grown by `rounding` to give the shape, 0 inside
    - `rounding`, `smallest_radius` (of curvature), `reference_point`, `bounding_box` ((x, y), (x, y)), `convex`
      (True, unless it says otherwise)
    - `outline(count, low, high)`: that many points around it, an array with two columns
    """
    def register(shape: type) -> type:
        _callable(shape, "obstacle")
        missing = [word for word in ("at", "core_distance", "outline") if not callable(getattr(shape, word, None))]
        if missing:
            raise TypeError(f"obstacle '{name}': {shape.__name__} has no method {missing[0]}()")
        if not hasattr(shape, "convex"):
            shape.convex = True  # type: ignore[attr-defined]
        _register("obstacle", name, _native.obstacle(name, _about(shape), shape, schema))
        return shape

    _texts([name], "name")
    schema = _options(options)
    return register


def check(name: str, /, **options: Any) -> list[str]:
    """Checks a component of this process as the test kit checks plugins: derivatives, kinks, what it reads, whether its
    distance is one, and so on. What is wrong, in words; an empty list: nothing.
    """
    found = [component for (_, known), component in _registered.items() if known == name]
    if not found:
        raise ValueError(f"name: found {name!r}, expected one of {sorted({known for _, known in _registered})}")
    return [line for component in found for line in _native.check(component, options).strip().splitlines()]


def unregister(name: str) -> None:
    """Takes a component of this process away. Scenes that were opened with it keep it."""
    for key in [key for key in _registered if key[1] == name]:
        del _registered[key]


def components() -> list[Any]:
    """All that are registered, as the library takes them."""
    return list(_registered.values())


def _register(kind: str, name: str, component: Any) -> None:
    _registered[kind, name] = component


def _callable(given: Any, kind: str) -> None:
    if not callable(given):
        raise TypeError(f"{kind}: found {given!r}, expected a function or a class")


def _about(given: Any) -> str:
    return (given.__doc__ or "of this process").strip().splitlines()[0]


def _texts(values: list[Any], name: str) -> list[str]:
    for value in values:
        if not isinstance(value, str):
            raise TypeError(f"{name}: found {value!r}, expected text")
    return values


def _options(options: Options | None) -> list[tuple[str, Any, str, str, float, float]]:
    if options is not None and not isinstance(options, Mapping):
        raise TypeError(f"options: found {options!r}, expected a dictionary")
    all_options = []
    for name, value in (options or {}).items():
        _texts([name], "options")
        option = value if isinstance(value, Option) else Option(value)
        default = list(option.default) if isinstance(option.default, (list, tuple)) else option.default
        _texts([option.unit, option.description], f"options['{name}']")
        all_options.append((name, default, option.unit, option.description, number(option.minimum, f"options['{name}'].minimum"),
                            number(option.maximum, f"options['{name}'].maximum")))
    return all_options
