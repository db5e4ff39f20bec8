"""The arguments of every method of `Model`, by kind: good values, and values that mean nothing."""

from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

import sympy

from codegen import Constraint, Model, alpha, t
from codegen.declare.body import Body
from codegen.errors import FAILURES
from codegen.plain_values import finite_float, members
from tests.fuzz.declared_nonsense import of_number, of_object, of_scalar, u


@dataclass
class Scenery:
    """A small sound machine, to whose parts the arguments of calls refer."""

    model: Model

    def __post_init__(self) -> None:
        model = self.model
        self.a = model.body("a", mass=1.0, inertia=2.0)
        self.b = model.body("b", mass=3.0, inertia=0.5)
        self.p = model.particle("p", mass=2.0)
        self.k = model.parameter("k", 5.0, unit="N/m")
        self.pin = model.revolute("pin", model.ground.at(0, 0), self.a.at(-1, 0))
        self.law = model.table("law", [0, 1, 2, 3], [0, 1, 0.5, 2])
        self.other = Model("other").body("a", 1.0, 1.0)

    def number(self, random: Random) -> Any:
        return random.choice([1.5, 2, 0.25, sympy.Rational(1, 3), sympy.pi, self.k, 2 * self.k])

    def expression(self, random: Random) -> Any:
        a, p = self.a, self.p
        varied = [a.x, sympy.sin(a.phi) * p.vx, p.x**2, -a.omega, sympy.cos(3 * t), self.law(p.x)]
        return random.choice([*varied, self.number(random)])


Make = Callable[[Scenery, Random], Any]


@dataclass(frozen=True)
class Kind:
    """A kind of argument: good values, and values that mean nothing there."""

    good: Make
    bad: Make


def nothing(scenery: Scenery, random: Random) -> Any:
    return None


def is_pair(value: Any) -> bool:
    """Whether it lists two numbers, as a quantity or a series does too."""
    try:
        pair = members(getattr(value, "magnitude", value), 2)
        return all(finite_float(member) is not None for member in pair)
    except FAILURES:
        return False


def _object(scenery: Scenery, random: Random) -> Any:
    return of_object(random)


def _things(s: Scenery) -> list[Any]:
    """Parts of a machine, each of which is nonsense in most places."""
    things = [s.model, s.a, s.p, s.model.ground, s.a.at(1, 0), s.pin, s.law, s.a.circle(1), s.a.at]
    return [*things, s.other, s.model.revolute, Body, Model, Body("z", None, None, None)]


def _of(make: Callable[[Random], Any], unless: tuple[type, ...] = ()) -> Make:
    """Nonsense of a kind, now and then a part of a machine, never of the types `unless`."""

    def bad(scenery: Scenery, random: Random) -> Any:
        for _ in range(99):
            value = random.choice(_things(scenery)) if random.random() < 0.2 else make(random)
            if not {*type.mro(type(value))} & {*unless}:
                return value
        return 7

    return bad


def _point(s: Scenery, random: Random) -> Any:
    body = random.choice([s.a, s.b, s.model.ground])
    return random.choice([body.at(s.number(random), 0), body.at(0, -1), body, s.p, s.p.at(0, 0)])


def _bad_point(s: Scenery, random: Random) -> Any:
    if random.random() < 0.5:
        pair = [of_scalar(random, lambda: None), 0.5]
        random.shuffle(pair)
        return random.choice([s.a, s.b, s.model.ground]).at(*pair)
    return _of(of_object, (Body, type(s.a.at(0, 0))))(s, random)


def _sequence(size: int, make: Make) -> Make:
    return lambda s, random: random.choice([tuple, list])(make(s, random) for _ in range(size))


def _spoilt(size: int, good: Make, bad: Callable[[Random], Any]) -> Make:
    """A list with an entry that is nonsense, of a wrong size, or no list."""

    def spoil(s: Scenery, random: Random) -> Any:
        which = random.random()
        if which < 0.4:
            values = [good(s, random) for _ in range(size)]
            values[random.randrange(size)] = bad(random)
            return tuple(values)
        if which < 0.6:
            return [good(s, random) for _ in range(random.choice([0, 1, size + 1]))] or 7
        if which < 0.8:
            return {1.0, 2.0, 0.5} if size == 3 else {1.0, 2.0}
        return random.choice([7, None, "ab", {1: 2, 3: 4}, 1.5, {0.5}, object(), "abc", b"ab"])

    return spoil


def _scalar(make: str) -> Kind:
    return Kind(lambda s, r: getattr(s, make)(r), _of(lambda r: of_scalar(r, lambda: u.m)))


def words(*words: Any) -> Kind:
    return Kind(lambda s, r: r.choice(words), _of(of_object))


def _law(s: Scenery, random: Random) -> Any:
    return random.choice([0.5 + 0.1 * sympy.sin(t), 1 + t, s.law(t), 2 * s.k, 1.25])


def _condition(s: Scenery, random: Random) -> Any:
    return random.choice([s.a.x > 0, sympy.And(s.p.vx < 1, t > 2), sympy.Not(s.a.phi >= s.k), None])


def _bad_condition(s: Scenery, random: Random) -> Any:
    odd = of_scalar(random)
    if issubclass(type(odd), sympy.Expr) and random.random() < 0.5:
        try:
            return s.a.x > odd
        except FAILURES:  # of SymPy, or of the odd object
            return True
    return random.choice(
        [
            True,
            False,
            "a.x > 0",
            1,
            s.a.x,
            lambda: True,
            [s.a.x > 0],
            alpha > 1,
            sympy.And(sympy.Symbol("q"), s.a.x > 0),
            object(),
            {s.a.x > 0},
        ]
    )


def _bad_callable(s: Scenery, random: Random) -> Any:
    answer = of_scalar(random, lambda: None)
    return random.choice(
        [
            lambda *_: answer,
            lambda *_: None,
            lambda *_: (1, 2),
            lambda: 1,
            lambda one: one,
            7,
            "f",
            lambda *_: 1 / 0,
            lambda *_: "5",
            [],
            lambda s, v: s[0],
            lambda s, v: s.nothing,
            dict,
        ]
    )


def _curve(s: Scenery, random: Random) -> Any:
    body = random.choice([s.a, s.b])
    return random.choice(
        [
            body.circle(0.3),
            body.polar(1 + 0.1 * sympy.cos(alpha)),
            body.curve(sympy.cos(alpha), 2 * sympy.sin(alpha)),
        ]
    )


def _bad_curve(s: Scenery, random: Random) -> Any:
    odd = of_scalar(random, lambda: None, lambda: s.a.x * alpha, lambda: 2 * u.rad)
    while is_pair(odd) or (issubclass(type(odd), sympy.Expr) and odd.free_symbols == {alpha}):
        odd = of_scalar(random)
    return random.choice(
        [
            lambda: s.a.circle(odd),
            lambda: s.a.circle(1, odd),
            lambda: 7,
            lambda: s.a.circle(1, (0, odd)),
            lambda: s.a.curve(odd, alpha),
            lambda: s.a.polar(odd),
            lambda: s.a.at(0, 0),
            lambda: odd,
        ]
    )()


def states(s: Scenery, random: Random) -> Any:
    return random.choice([{"a.phi": 0.5}, {s.a.phi: 1}, {s.p.vx: 2.0, "b.x": 0.1}, {}, None])


def bad_mapping(good: list[Any], make: Callable[[Random], Any]) -> Make:
    def bad(s: Scenery, random: Random) -> Any:
        if random.random() < 0.6:
            return {random.choice(good): make(random)}
        key = random.choice(["nothing", 7, None, (1, 2), s.a, sympy.Symbol("z"), "a", 1.5, b"a.x"])
        return random.choice([{key: 1.0}, 7, "a.x", [("a.x", 1.0)], {"a.x"}, object(), [1]])

    return bad


def bad_names(s: Scenery, random: Random) -> Any:
    odd = random.choice([7, None, "nothing", object(), 1.5, "a\nb", s.other, s.a.at(0, 0), s.k, {}])
    return random.choice([[odd], ["pin", odd], 7 if odd == {} else odd, (k for k in [odd]), 5])


def _bad_pair(random: Random) -> Any:
    pair = random.choice([of_number(random), (1, of_number(random)), {1.0, 2.0}])
    return 7 if is_pair(pair) else pair


NUMBER, SCALAR = _scalar("number"), _scalar("expression")
PLACE = Kind(_point, _bad_point)
BODY = Kind(lambda s, r: r.choice([s.a, s.b]), _of(of_object, (Body,)))
PAIR = Kind(_sequence(2, Scenery.number), _spoilt(2, Scenery.number, of_scalar))
TRIPLE = Kind(_sequence(3, Scenery.number), _spoilt(3, Scenery.number, of_scalar))
LETTER = words("x", "y")
LAW = Kind(_law, _of(lambda r: of_scalar(r, lambda: None, lambda: sympy.Symbol("a_x", real=True))))
CONDITION = Kind(_condition, _bad_condition)
WHEN = Kind(
    lambda s, r: r.choice([s.a.x > 0, sympy.And(s.p.vx < 1, t > 2), s.b.omega >= s.k]),
    lambda s, r: None if r.random() < 0.1 else _bad_condition(s, r),
)
UNTIL = Kind(
    lambda s, r: r.choice([None, {}, {"ended": s.a.x > 0}, {"far": s.p.vx < s.k, "late": t > 1}]),
    lambda s, r: r.choice(
        [{"ended": _bad_condition(s, r)}, {7: s.a.x > 0}, {"a": s.a.x > 0}, 7, "a", [s.a.x > 0]]
    ),
)
TIME = Kind(
    lambda s, r: r.choice([0.5, 1, sympy.Rational(1, 100)]),
    lambda s, r: r.choice([-1.0, -3, of_number(r)]),
)
# messages about the rate say the name of the state
STATE = Kind(lambda s, r: s.model.state("by_state_equation"), _of(of_object))
CALLABLE = Kind(
    lambda s, r: r.choice([lambda s, v: 2 * v, lambda s, v: 3 * s**2, None]), _bad_callable
)
CURVE = Kind(_curve, _bad_curve)
FLAG = Kind(
    lambda s, r: r.choice([True, False]),
    lambda s, r: r.choice([1, 0, "no", None, [], "yes", 2.5, object()]),
)
JOINT = Kind(lambda s, r: s.pin, _of(of_object, (Constraint,)))
STAND_IN = Kind(
    nothing,
    lambda s, r: r.choice([s.model.ground, s.other, s.pin, 7, "a", s.a.at(0, 0), object(), [s.a]]),
)
UNIT = Kind(
    lambda s, r: r.choice(["", "m", "kg m^2", "N s/m", "rad/s"]),
    lambda s, r: r.choice(
        [
            "9**9**9**9",
            "m^9^9",
            "bananas",
            "km",
            7,
            None,
            "m\nimport os",
            [],
            "m)",
            "(" * 200,
            "__import__('os')",
            "m" * 500,
            "1e9",
            "m**1e9",
            b"m",
            "\ud800",
            "m^(2^(2^99))",
        ]
    ),
)
PLAIN = Kind(lambda s, r: r.choice([1.5, 2, sympy.pi / 3]), _of(of_number))
POINTS = Kind(
    lambda s, r: [(0, 0), (1, 0), (1.5, 1), (0.5, 2), (-0.5, 1)],
    lambda s, r: (
        [(0, 0), (1, 0), _bad_pair(r), (1, 1), (0, 1)]
        if r.random() < 0.7
        else r.choice([7, None, "abcd", {(0, 0), (1, 0), (1, 1), (0, 1)}, [1, 2, 3, 4], object()])
    ),
)
COLUMN = Kind(
    lambda s, r: [0, 1, 2.5, 3.5],
    lambda s, r: (
        [0, 1, of_number(r), 3.5]
        if r.random() < 0.6
        else r.choice(
            [7, None, "0123", {0, 1, 2, 3}, [0, 1, "a", 4], object(), {0: 1, 1: 2, 2: 3, 3: 4}]
        )
    ),
)
COMPONENTS = Kind(
    lambda s, r: {s.a.x: 1.0, s.p.y: s.k},
    lambda s, r: r.choice(
        [{s.a.x: of_scalar(r, lambda: None)}, {"a.x": 1}, {7: 1}, [1], None, {}, {s.a.vx: 1}, 7]
    ),
)
CHOICES = Kind(
    lambda s, r: {"one": [s.pin], "two": []},
    lambda s, r: r.choice(
        [
            {"one": [7], "two": []},
            {7: [], "two": []},
            7,
            None,
            [("one", [])],
            {"one": ["pin"]},
            {"one": 7, "two": None},
            {"one": ["nothing"], "two": [object()]},
        ]
    ),
)
NAMES = Kind(lambda s, r: r.choice([(), ["pin"], "pin", [s.pin]]), bad_names)
PATH = Kind(
    lambda s, r: __file__,
    lambda s, r: r.choice([7, None, "", "nothing.csv", b"x", "a\0b", [], object(), "\ud800"]),
)
