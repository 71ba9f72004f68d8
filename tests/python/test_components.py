"""Objective terms, coordinate models and obstacle shapes that are written in Python."""

import math
import os
import signal
import threading
import time

import numpy as np
import pytest

import tendril


@pytest.fixture(autouse=True)
def nothing_is_left():
    before = set(tendril._components._registered)
    yield
    for key in set(tendril._components._registered) - before:
        del tendril._components._registered[key]


def same_plan(a, b, tolerance=1e-9):
    assert a.status == b.status == "solved"
    assert a.objective == pytest.approx(b.objective, rel=tolerance)
    assert a.moments == pytest.approx(b.moments, rel=tolerance)
    assert a.tip == pytest.approx(b.tip, abs=tolerance)


def with_term(scene, name, **options):
    terms = scene.to_dict()["objective"]
    return scene.copy({"objective": [{**terms[0], "plugin": name, **options}, *terms[1:]]})


@pytest.mark.parametrize("solver", ["nlopt", "ipopt", "ceres"])
def test_a_term_plans_what_the_plugin_plans(brace, solver):
    scene = brace.copy({"solver.plugin": solver})

    @tendril.objective("to_target", reads=["tip_position", "target"])
    def to_target(x):
        return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

    same_plan(with_term(scene, "to_target").plan(), scene.plan(), 1e-7)


def test_a_number_is_added_as_it_is(brace):
    @tendril.objective("squared", reads=["tip_position", "target"])
    def squared(x):
        return (x.tip.x - x.target.position[0]) ** 2 + (x.tip.y - x.target.position[1]) ** 2

    same_plan(with_term(brace, "squared").plan(), brace.plan(), 1e-7)
    assert tendril.check("squared") == []


@pytest.mark.parametrize("wanted", [0.9, 1.2])
def test_a_term_reads_the_insertion(wanted):
    """A rod that is drawn in and out goes where the term wants it, or to its limit; one that is not is out as a whole.
    The unit is what is out at most.
    """
    @tendril.objective("out_by", reads=["insertion"], options={"share": 1.0})
    def out_by(x, share):
        return [x.insertion - share]

    rod = {"length": 0.2, "bending_stiffness": 2e-3, "actuator": [{"limit": 0.01}]}
    terms = [{"plugin": "actuation_effort"}, {"plugin": "out_by", "weight": 1e3, "share": wanted}]
    drawn = tendril.Scene(problem="pose", rod={**rod, "insertion": {"min": 0.1, "max": 0.16}}, objective=terms)
    assert drawn.plan().to_dict()["insertion"] == pytest.approx(0.16 * min(wanted, 1.0), rel=1e-6)
    still = tendril.Scene(problem="pose", rod=rod, objective=terms).plan()
    assert still.objective == pytest.approx(1e3 * (1.0 - wanted) ** 2, rel=1e-6)


def formula(np, x):
    """Uses everything that derivatives have to pass."""
    c = x.contacts[0] if x.contacts else None
    value = np.sin(x.tip.x) * np.exp(0.3 * x.tip.y) - np.cos(x.tip.angle) / (2.0 + np.tanh(x.moments[0]))
    value = value + np.arctan2(x.tip.y + 3.0, x.tip.x) + np.hypot(x.samples[0].x, 1.0 + x.samples[0].y * x.samples[0].y)
    value = value + np.sqrt(2.0 + x.samples[0].angle**2) + np.log(3.0 + x.samples[0].curvature / 5.0) + abs(-2.0 - x.tip.y)
    value = value + np.sinh(x.bending_energy / 5) - np.cosh(x.moments[-1] / 3.0) ** 1.5 + np.arctan(x.tip.x) + np.tan(x.tip.y / 3)
    value = value + np.exp(0.05 * x.tensions[0]) * x.shortenings[-1] + x.samples[0].strain ** 3
    value = value + x.insertion**2 * x.tip.x
    value = value + sum(one.x * one.y**2 for one in x.tip_deviations)
    value = value + 1.1**x.tip.x - (3.0 - x.tip.y) ** (0.1 * x.tip.x) + np.square(x.tip.x) + 1.0 / (2.0 + x.tip.x)
    if c is not None:
        value = value + c.force * c.gap + c.normal_x * c.normal_y - c.arc_length**3 + c.x * c.y
    return value


READS = ["tip_position", "tip_angle", "moments", "tensions", "shortenings", "bending_energy", "contact_point", "contact_gap", "contact_normal",
         "contact_force", "contact_arc_length", "insertion", "tip_deviations"]


def test_derivatives_pass_the_test_kit():
    @tendril.objective("everything", reads=READS, samples=[0.4, 0.7], lower_bound=-math.inf)
    def everything(x):
        return formula(np, x)

    @tendril.objective("rows", reads=READS, samples=[0.5])
    def rows(x):
        return np.array([x.tip.x, 2 * x.tip.y, x.moments[0] * x.tip.angle, 0.5, x.bending_energy - 1.0])

    assert tendril.check("everything") == []
    assert tendril.check("rows") == []


@pytest.mark.parametrize("made, word", [
    (lambda x: abs(x.tip.x) * 1.0, "kink"),
    (lambda x: x.tip.x - 1.0, "lower_bound"),
    (lambda x: x.tip.x * float("nan"), "finite"),
    (lambda x: x.tip.x.value ** 2, "first derivative"),
])
def test_the_kit_finds_what_is_wrong(made, word):
    tendril.objective("flawed", reads=["tip_position"], lower_bound=0.0)(made)
    try:
        found = " ".join(tendril.check("flawed"))
    except tendril.Error as error:  # what no plan could go on with is an error at once
        found = str(error)
    assert word in found


def test_options_have_units_and_defaults(brace):
    seen = {}

    @tendril.objective("level", reads=["tip_angle", "tip_position"],
                       options={"angle": tendril.Option(0.0, unit="rad"), "height": tendril.Option(unit="m"),
                                "strict": False, "word": "no", "order": 3, "list": [1.0, 2.0]})
    def level(x, angle, height, **rest):
        seen.update(rest, angle=angle, height=height)
        return [x.tip.angle - angle, x.tip.y - height]

    with pytest.raises(tendril.Error, match="height"):
        with_term(brace, "level").plan()
    plan = with_term(brace, "level", angle="5 deg", height="20 mm").plan()
    assert plan.solved and seen["angle"] == pytest.approx(math.radians(5)) and seen["height"] == pytest.approx(0.2)
    assert (seen["strict"], seen["word"], seen["order"], seen["list"]) == (False, "no", 3, [1.0, 2.0])
    with pytest.raises(tendril.Error, match="did you mean 'height'"):
        with_term(brace, "level", hight="20 mm").plan()


@pytest.mark.parametrize("returned, message", [
    (None, "found None, expected a number"),
    ("text", "found 'text', expected a number"),
    (True, "found True, expected a number"),
    ([None], "found None, expected a number"),
    ({}, "found {}, expected a number"),
    (1j, "found 1j, expected a number"),
    (np.zeros((2, 2)), r"found array\(\[0., 0.\]\), expected a number"),
])
def test_what_is_no_number_is_refused(brace, returned, message):
    @tendril.objective("wrong", reads=["tip_position"])
    def wrong(x):
        return returned

    with pytest.raises(tendril.Error, match=message) as error:
        with_term(brace, "wrong").plan()
    assert "objective 'wrong' of this program" in str(error.value)


@pytest.mark.parametrize("factor", [math.nan, math.inf])
def test_what_is_not_finite_is_no_plan(brace, factor):
    tendril.objective("wild", reads=["tip_position"])(lambda x: (2.0 + x.tip.x) * factor)
    plan = with_term(brace, "wild").plan()
    assert plan.status == "failed" and "objective 'wild'" in plan.message


def test_other_numbers_of_residuals_are_refused(brace):
    calls = []

    @tendril.objective("ragged", reads=["tip_position"])
    def ragged(x):
        calls.append(1)
        return [x.tip.x] * (1 + len(calls) % 2)

    with pytest.raises(tendril.Error, match="objective 'ragged' changed its number of residuals"):
        with_term(brace, "ragged").plan()


@pytest.mark.parametrize("raised, told", [(SystemExit(3), "SystemExit: 3"), (RecursionError("deep"), "RecursionError: deep"),
                                          (MemoryError(), "MemoryError")])
def test_no_exception_ends_the_interpreter(brace, raised, told):
    @tendril.objective("throws", reads=["tip_position"])
    def throws(x):
        raise raised

    with pytest.raises(tendril.Error, match=told):
        with_term(brace, "throws").plan()


@pytest.mark.parametrize("make, kind, name", [
    (lambda: tendril.objective(3), TypeError, "name"),
    (lambda: tendril.objective("x")(3), TypeError, "objective"),
    (lambda: tendril.objective("x", reads=3), TypeError, "reads"),
    (lambda: tendril.objective("x", reads="tip_angle"), TypeError, "reads"),
    (lambda: tendril.objective("x", reads=[3]), TypeError, "reads"),
    (lambda: tendril.objective("x", samples=0.5), TypeError, "samples"),
    (lambda: tendril.objective("x", samples=[math.nan]), ValueError, r"samples\[0\]"),
    (lambda: tendril.objective("x", samples=[0.5, 2.0]), ValueError, r"samples\[1\]"),
    (lambda: tendril.objective("x", samples=["x"]), TypeError, r"samples\[0\]"),
    (lambda: tendril.objective("x", lower_bound=None), TypeError, "lower_bound"),
    (lambda: tendril.objective("x", lower_bound=math.nan), ValueError, "lower_bound"),
    (lambda: tendril.objective("x", options=3), TypeError, "options"),
    (lambda: tendril.objective("x", options={"r": tendril.Option(1.0, unit="kg")})(lambda x: x), ValueError, r"options\['r'\].unit"),
    (lambda: tendril.objective("x", options={"r": tendril.Option(1.0, minimum="x")}), TypeError, r"options\['r'\].minimum"),
    (lambda: tendril.objective("x", options={"r": object()})(lambda x: x), ValueError, "default of 'r'"),
    (lambda: tendril.coordinates("x", functions=None), ValueError, "functions"),
    (lambda: tendril.coordinates("x", functions=2.5), ValueError, "functions"),
    (lambda: tendril.coordinates(3, functions=2), TypeError, "name"),
    (lambda: tendril.obstacle(3), TypeError, "name"),
    (lambda: tendril.obstacle("x")(3), TypeError, "obstacle"),
    (lambda: tendril.check(3), ValueError, "name"),
])
def test_wrong_declarations_name_the_argument(make, kind, name):
    with pytest.raises(kind, match=name):
        make()


def test_what_it_raises_is_told_with_its_place(brace):
    @tendril.objective("raises", reads=["tip_position"])
    def raises(x):
        return [][1]

    with pytest.raises(tendril.Error, match=r"IndexError: list index out of range, at .*test_components\.py:\d+"):
        with_term(brace, "raises").plan()


def test_what_is_not_read_is_told(brace):
    @tendril.objective("reads_more", reads=["tip_position"])
    def reads_more(x):
        return x.tip.x * x.tip.angle

    with pytest.raises(tendril.Error, match='expected "tip_angle" among its `reads`'):
        with_term(brace, "reads_more").plan()
    with pytest.raises(ValueError, match="did you mean 'tip_angle'"):
        tendril.objective("x", reads=["tip_angel"])(lambda x: 0.0)


def test_what_is_not_read_and_only_handed_on_is_told(brace):
    @tendril.objective("hands_on", reads=["tip_angle"])
    def hands_on(x):
        return x.tip.x

    with pytest.raises(tendril.Error, match='hands_on.*found "tip_position", which is not among its `reads`'):
        brace.copy(objective=[{"plugin": "hands_on"}]).plan()


def test_math_is_refused_with_a_hint(brace):
    @tendril.objective("by_math", reads=["tip_position"])
    def by_math(x):
        return math.sin(x.tip.x)

    with pytest.raises(tendril.Error, match="use numpy's functions"):
        with_term(brace, "by_math").plan()


def test_quantities_of_two_evaluations_do_not_meet():
    kept = []

    @tendril.objective("keeps", reads=["tip_position", "moments"], lower_bound=-math.inf)
    def keeps(x):
        kept.append(x.tip.x)
        return kept[0] * x.tip.x * sum(x.moments)

    @tendril.objective("other", reads=["tip_position"], lower_bound=-math.inf)
    def other(x):
        return sum(kept[-50:]) * x.tip.x

    tendril.check("keeps")
    with pytest.raises(tendril.Error, match="different evaluations"):
        tendril.check("other")


def test_a_name_that_is_taken_is_refused(brace):
    tendril.objective("tip_pose", reads=["tip_position"])(lambda x: 0.0)
    with pytest.raises(tendril.Error, match="objective 'tip_pose' is there already"):
        brace.plan()
    tendril.unregister("tip_pose")
    tendril.objective("Tip Pose", reads=["tip_position"])(lambda x: 0.0)
    with pytest.raises(tendril.Error, match="is no name of a component"):
        brace.plan()


def test_a_wrong_name_is_answered_with_the_nearest(brace):
    tendril.objective("level_tip", reads=["tip_angle"])(lambda x: x.tip.angle**2)
    with pytest.raises(tendril.Error, match="did you mean 'level_tip'"):
        with_term(brace, "level_tipp").plan()


def legendre(order):
    """The basis of the plugin by numpy's own polynomials."""
    from numpy.polynomial import Polynomial
    from numpy.polynomial.legendre import Legendre

    slopes = [Legendre.basis(i, domain=[0, 1]).convert(kind=Polynomial) for i in range(order)]
    return [slope.integ() for slope in slopes]


def test_coordinates_plan_what_the_plugin_plans(brace):
    @tendril.coordinates("by_numpy", functions=lambda order: order, options={"order": 4},
                         names=lambda order: [f"a_{i}" for i in range(order)])
    def by_numpy(sigma, order):
        basis = legendre(order)
        return tuple(np.stack([f.deriv(d)(sigma) if d else f(sigma) for f in basis], axis=1) for d in range(3))

    assert tendril.check("by_numpy") == []
    own = brace.copy({"coordinates": {"plugin": "by_numpy", "order": 6}})
    same_plan(own.plan(), brace.plan(), 1e-8)
    assert own.describe().variables == brace.describe().variables


def zeros(sigma):
    return (np.zeros((len(sigma), 2)),) * 3


@pytest.mark.parametrize("basis, declared, told", [
    (lambda sigma: None, {}, "the basis: found None, expected three arrays"),
    (lambda sigma: zeros(sigma)[:2], {}, "expected three arrays"),
    (lambda sigma: ("a", "b", "c"), {}, "the values: found 'a', expected an array"),
    (lambda sigma: [part * math.nan for part in zeros(sigma)], {}, "not finite"),
    (lambda sigma: [][1], {}, "IndexError"),
    (zeros, {"functions": lambda: math.nan}, "functions: found nan, expected a whole number"),
    (zeros, {"functions": lambda: 10**30}, "functions: found 1000.*, expected a whole number"),
    (zeros, {"functions": lambda: None}, "functions: found None"),
    (zeros, {"breaks": 3}, "breaks: found 3, expected a list"),
    (zeros, {"breaks": [math.nan]}, "breaks"),
    (zeros, {"subdivision": [-1.0]}, "subdivision"),
])
def test_wrong_bases_are_refused(brace, basis, declared, told):
    tendril.coordinates("wrong", **{"functions": 2, **declared})(basis)
    with pytest.raises(tendril.Error, match=told):
        brace.copy({"coordinates": {"plugin": "wrong"}}).plan()


def test_wrong_arrays_are_refused(brace):
    @tendril.coordinates("short", functions=2)
    def short(sigma):
        return np.zeros((len(sigma), 1)), np.zeros((len(sigma), 2)), np.zeros((len(sigma), 2))

    with pytest.raises(tendril.Error, match=r"the values of shape: found \(\d+, 1\), expected an array .*, 2\)"):
        brace.copy({"coordinates": {"plugin": "short"}}).plan()


class Disc:
    """A circle."""

    convex = True

    def __init__(self, radius, x, y):
        self.rounding = self.smallest_radius = radius
        self.reference_point = (x, y)
        self.bounding_box = ((x - radius, y - radius), (x + radius, y + radius))

    def at(self, x, y):
        dx, dy = x - self.reference_point[0], y - self.reference_point[1]
        r = math.hypot(dx, dy)
        if r == 0.0:  # every normal is as good
            return -self.rounding, (1.0, 0.0), 0.0, 0.0
        return r - self.rounding, (dx / r, dy / r), 1.0 / r, 0.0

    def core_distance(self, x, y):
        return math.hypot(x - self.reference_point[0], y - self.reference_point[1])

    def outline(self, count, low, high):
        turn = 2 * np.pi * np.arange(count) / count
        return np.stack([self.reference_point[0] + self.rounding * np.cos(turn),
                         self.reference_point[1] + self.rounding * np.sin(turn)], axis=1)


DISC = {name: tendril.Option(unit="m", default=0.1) for name in ("radius", "x", "y")}


def test_an_obstacle_plans_what_the_circle_plans(brace):
    tendril.obstacle("disc", options=DISC)(Disc)
    assert tendril.check("disc") == []
    scene = brace.copy({"obstacle": [{"shape": "disc", "radius": "8 mm", "x": "60 mm", "y": "0 mm"}]})
    plan = scene.plan()
    same_plan(plan, brace.plan())
    assert plan.contacts[0].force == pytest.approx(brace.plan().contacts[0].force, rel=1e-9)
    same = scene.execute(plan)
    assert same.tip.x == pytest.approx(plan.tip.x, abs=1e-9)
    assert plan.plot() is not None


@pytest.mark.parametrize("wrong, told", [
    ({"at": lambda self, x, y: None}, r"at\(\): found None"),
    ({"at": lambda self, x, y: (math.nan, (1.0, 0.0), 0.0, 0.0)}, "not finite"),
    ({"at": lambda self, x, y: (1.0, (1.0, 0.0, 0.0), 0.0, 0.0)}, "the normal: found"),
    ({"at": lambda self, x, y: (1.0, (3.0, 0.0), 0.0, 0.0)}, "no unit vector"),
    ({"at": lambda self, x, y: 1 / 0}, "ZeroDivisionError"),
    ({"core_distance": lambda self, x, y: None}, r"core_distance\(\): found None"),
    ({"convex": "yes"}, "convex: found 'yes', expected True or False"),
    ({"convex": None}, "convex: found None"),
    ({"reference_point": property(lambda self: 3)}, "reference_point"),
    ({"rounding": property(lambda self: None)}, "rounding: found None"),
    ({"bounding_box": property(lambda self: [1])}, "bounding_box"),
])
def test_wrong_obstacles_are_refused(brace, wrong, told):
    settable = {name: property(value.fget, lambda self, given: None) if isinstance(value, property) else value
                for name, value in wrong.items()}
    tendril.obstacle("wrong", options=DISC)(type("Wrong", (Disc,), settable))
    with pytest.raises(tendril.Error, match=told):
        brace.copy({"obstacle": [{"shape": "wrong", "radius": "8 mm", "x": "60 mm", "y": "0 mm"}]}).plan()


def test_a_wrong_outline_is_no_picture(brace):
    tendril.obstacle("wrong", options=DISC)(type("Wrong", (Disc,), {"outline": lambda self, count, low, high: np.zeros((2, 2))}))
    plan = brace.copy({"obstacle": [{"shape": "wrong", "radius": "8 mm", "x": "60 mm", "y": "0 mm"}]}).plan()
    with pytest.warns(UserWarning, match=r"outline\(\) of shape: found \(2, 2\)"):
        plan.plot()


def test_an_obstacle_without_a_method_is_refused():
    with pytest.raises(TypeError, match=r"has no method core_distance\(\)"):
        tendril.obstacle("half")(type("Half", (), {"at": lambda self, x, y: None}))


def test_processes_that_are_forked_know_components(brace):
    @tendril.objective("square_tip", reads=["tip_position", "target"])
    def square_tip(x):
        return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

    scene = with_term(brace, "square_tip")
    assert [r.solved for r in tendril.plan_many([scene, brace], jobs=2, start_method="fork")] == [True, True]


def test_loops_and_threads_use_components(brace):
    @tendril.objective("square_tip", reads=["tip_position", "target"])
    def square_tip(x):
        return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

    problem = with_term(brace, "square_tip").problem()
    for y in np.linspace(0.02, 0.018, 5):
        problem.follow((0.097, y))
        assert problem.solved
    results = []
    threads = [threading.Thread(target=lambda: results.append(with_term(brace, "square_tip").plan())) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 3 and all(r.to_dict()["moments"] == results[0].to_dict()["moments"] for r in results)


def test_interrupt_in_a_term_ends_the_plan(brace):
    @tendril.objective("slow", reads=["tip_position", "target"])
    def slow(x):
        if threading.current_thread() is threading.main_thread() and not told:
            told.append(True)
            os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.001)
        return [x.tip.x - x.target.position[0], x.tip.y - x.target.position[1]]

    told = []
    with pytest.raises(KeyboardInterrupt):
        with_term(brace, "slow").plan()
    assert with_term(brace, "slow").plan().solved
