"""Declarations with arguments of the wrong kind, from a seed.

    python -m tests.fuzz declarations --count 100000 --seed 1

A case is a small machine, and a few calls of the methods of `Model` whose arguments are good, or
mean nothing where they stand. Its scenes are checked, derived, lowered and written, but not
compiled. Nonsense must be refused by an error of Linkwright's own that names the element, soon, and
nothing of what was given may be evaluated; what is accepted must come out as text that is sound.
"""

import argparse
import ast
import sys
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from random import Random
from typing import Any

import sympy

from codegen import Constraint, Effect, LinkwrightError, Model, Statement, alpha, t
from codegen.declare.body import Body
from codegen.derive.equations import derive
from codegen.driver import valid_scenes
from codegen.emit.module import Origin, module_text
from codegen.lower.kernels.scene_kernels import lower
from tests.fuzz import campaign
from tests.fuzz.declared_nonsense import MARK, of_number, of_object, of_scalar, u
from tests.fuzz.hostile_elements import hostile_body, hostile_element

LIMIT = 20.0  # seconds after which a case counts as hanging


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


def _none(scenery: Scenery, random: Random) -> Any:
    return None


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
            if not isinstance(value, unless):
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


def _words(*words: Any) -> Kind:
    return Kind(lambda s, r: r.choice(words), _of(of_object))


def _law(s: Scenery, random: Random) -> Any:
    return random.choice([0.5 + 0.1 * sympy.sin(t), 1 + t, s.law(t), 2 * s.k, 1.25])


def _condition(s: Scenery, random: Random) -> Any:
    return random.choice([s.a.x > 0, sympy.And(s.p.vx < 1, t > 2), sympy.Not(s.a.phi >= s.k), None])


def _bad_condition(s: Scenery, random: Random) -> Any:
    odd = of_scalar(random)
    if isinstance(odd, sympy.Expr) and random.random() < 0.5:
        try:
            return s.a.x > odd
        except TypeError:
            return True
    return random.choice([True, False, "a.x > 0", 1, s.a.x, lambda: True, [s.a.x > 0], alpha > 1,
                          sympy.And(sympy.Symbol("q"), s.a.x > 0), object(), {s.a.x > 0}])  # fmt: skip


def _bad_callable(s: Scenery, random: Random) -> Any:
    answer = of_scalar(random, lambda: None)
    return random.choice([
        lambda *_: answer, lambda *_: None, lambda *_: (1, 2), lambda: 1, lambda one: one, 7, "f",
        lambda *_: 1 / 0, lambda *_: "5", print, [], lambda l, v: l[0], lambda l, v: l.nothing, dict,
    ])  # fmt: skip


def _curve(s: Scenery, random: Random) -> Any:
    body = random.choice([s.a, s.b])
    return random.choice([body.circle(0.3), body.polar(1 + 0.1 * sympy.cos(alpha)),
                          body.curve(sympy.cos(alpha), 2 * sympy.sin(alpha))])  # fmt: skip


def _bad_curve(s: Scenery, random: Random) -> Any:
    odd = of_scalar(random, lambda: None, lambda: s.a.x * alpha)
    while odd == alpha or (isinstance(odd, sympy.Expr) and odd.free_symbols == {alpha}):
        odd = of_scalar(random)
    return random.choice([lambda: s.a.circle(odd), lambda: s.a.circle(1, odd), lambda: 7,
                          lambda: s.a.circle(1, (0, odd)), lambda: s.a.curve(odd, alpha),
                          lambda: s.a.polar(odd), lambda: s.a.at(0, 0), lambda: odd])()  # fmt: skip


def _states(s: Scenery, random: Random) -> Any:
    return random.choice([{"a.phi": 0.5}, {s.a.phi: 1}, {s.p.vx: 2.0, "b.x": 0.1}, {}, None])


def _bad_mapping(good: list[Any], make: Callable[[Random], Any]) -> Make:
    def bad(s: Scenery, random: Random) -> Any:
        if random.random() < 0.6:
            return {random.choice(good): make(random)}
        key = random.choice(["nothing", 7, None, (1, 2), s.a, sympy.Symbol("z"), "a", 1.5, b"a.x"])
        return random.choice([{key: 1.0}, 7, "a.x", [("a.x", 1.0)], {"a.x"}, object(), [1]])

    return bad


def _bad_names(s: Scenery, random: Random) -> Any:
    odd = random.choice([7, None, "nothing", object(), 1.5, "a\nb", s.other, s.a.at(0, 0), s.k, {}])
    return random.choice([[odd], odd or 7, ["pin", odd], {odd: 1} if odd != {} else 5, (k for k in [odd])])


NUMBER, SCALAR = _scalar("number"), _scalar("expression")
PLACE = Kind(_point, _bad_point)
BODY = Kind(lambda s, r: r.choice([s.a, s.b]), _of(of_object, (Body,)))
PAIR = Kind(_sequence(2, Scenery.number), _spoilt(2, Scenery.number, of_scalar))
TRIPLE = Kind(_sequence(3, Scenery.number), _spoilt(3, Scenery.number, of_scalar))
LETTER = _words("x", "y")
LAW = Kind(_law, _of(lambda r: of_scalar(r, lambda: None, lambda: sympy.Symbol("a_x", real=True))))
CONDITION = Kind(_condition, _bad_condition)
CALLABLE = Kind(lambda s, r: r.choice([lambda l, v: 2 * v, lambda l, v: 3 * l**2, None]), _bad_callable)
CURVE = Kind(_curve, _bad_curve)
FLAG = Kind(lambda s, r: r.choice([True, False]), lambda s, r: r.choice([1, 0, "no", None, [], "yes", 2.5, object()]))
JOINT = Kind(lambda s, r: s.pin, _of(of_object, (Constraint,)))
STAND_IN = Kind(_none, lambda s, r: r.choice([s.model.ground, s.other, s.pin, 7, "a", s.a.at(0, 0), object(), [s.a]]))
UNIT = Kind(
    lambda s, r: r.choice(["", "m", "kg m^2", "N s/m", "rad/s"]),
    lambda s, r: r.choice(["9**9**9**9", "m^9^9", "bananas", "km", 7, None, "m\nimport os", [], "m)", "(" * 200,
                           "__import__('os')", "m" * 500, "1e9", "m**1e9", u.m, b"m", "\ud800", "m^(2^(2^99))"]),
)
PLAIN = Kind(lambda s, r: r.choice([1.5, 2, sympy.pi / 3]), _of(of_number))
POINTS = Kind(
    lambda s, r: [(0, 0), (1, 0), (1.5, 1), (0.5, 2), (-0.5, 1)],
    lambda s, r: [(0, 0), (1, 0), r.choice([of_number(r), (1, of_number(r)), {1.0, 2.0}]), (1, 1), (0, 1)]
    if r.random() < 0.7 else r.choice([7, None, "abcd", {(0, 0), (1, 0), (1, 1), (0, 1)}, [1, 2, 3, 4], object()]),
)
COLUMN = Kind(
    lambda s, r: [0, 1, 2.5, 3.5],
    lambda s, r: [0, 1, of_number(r), 3.5] if r.random() < 0.6
    else r.choice([7, None, "0123", {0, 1, 2, 3}, [0, 0, 0, 0], object(), {0: 1, 1: 2, 2: 3, 3: 4}]),
)
COMPONENTS = Kind(
    lambda s, r: {s.a.x: 1.0, s.p.y: s.k},
    lambda s, r: r.choice([{s.a.x: of_scalar(r, lambda: None)}, {"a.x": 1}, {7: 1}, [1], None, {}, {s.a.vx: 1}, 7]),
)
CHOICES = Kind(
    lambda s, r: {"one": [s.pin], "two": []},
    lambda s, r: r.choice([{"one": [7], "two": []}, {7: [], "two": []}, 7, None, [("one", [])], {"one": ["pin"]},
                           {"one": 7, "two": None}, {"one": ["nothing"], "two": [object()]}]),
)
NAMES = Kind(lambda s, r: r.choice([(), ["pin"], "pin", [s.pin]]), _bad_names)
PATH = Kind(lambda s, r: __file__, lambda s, r: r.choice([7, None, "", "nothing.csv", b"x", "a\0b", [], object(), "\ud800"]))

METHODS: dict[str, dict[str, Kind]] = {
    "body": {"mass": NUMBER, "inertia": NUMBER},
    "particle": {"mass": NUMBER},
    "coupler": {"i": PLACE, "j": PLACE, "length": NUMBER, "mass": NUMBER, "inertia": NUMBER},
    "parameter": {"value": PLAIN, "unit?": UNIT, "sign?": _words("", "positive", "nonnegative")},
    "table": {"x": COLUMN, "y": COLUMN, "periodic?": FLAG},
    "depends_on": {"path": PATH},
    "gravity": {"g": PAIR},
    "force": {"on": PLACE, "fx?": SCALAR, "fy?": SCALAR, "when?": CONDITION, "frame?": _words("ground", "body")},
    "torque": {"on": BODY, "value": SCALAR, "when?": CONDITION},
    "potential": {"energy": NUMBER},
    "generalized_force": {"components": COMPONENTS, "when?": CONDITION},
    "spring": {
        "i": PLACE, "j": PLACE, "stiffness": NUMBER, "free_length": NUMBER, "damping?": SCALAR,
        "actuator?": SCALAR, "force?": CALLABLE,
    },
    "torsion_spring": {
        "i": BODY, "j": BODY, "stiffness": NUMBER, "free_angle?": NUMBER, "damping?": SCALAR,
        "actuator?": SCALAR, "torque?": CALLABLE,
    },
    "bushing": {"i": PLACE, "j": PLACE, "stiffness": TRIPLE, "damping?": TRIPLE, "free_angle?": NUMBER},
    "revolute": {"i": PLACE, "j": PLACE},
    "translational": {"i": PLACE, "j": PLACE, "axis?": PAIR, "angle?": NUMBER},
    "revolute_revolute": {"i": PLACE, "j": PLACE, "length": NUMBER, "instead_of?": STAND_IN},
    "revolute_translational": {
        "i": PLACE, "j": PLACE, "axis?": PAIR, "distance?": NUMBER, "instead_of?": STAND_IN
    },
    "weld": {"i": PLACE, "j": PLACE, "angle?": NUMBER},
    "gear": {"i": PLACE, "j": PLACE, "radius_i": NUMBER, "radius_j": NUMBER, "line?": NUMBER},
    "rack_and_pinion": {"pinion": PLACE, "rack": PLACE, "radius": NUMBER, "axis?": PAIR, "offset?": NUMBER},
    "absolute": {"on": PLACE, "letter": LETTER, "value": NUMBER},
    "relative": {"i": PLACE, "j": PLACE, "letter": LETTER, "value": NUMBER},
    "distance": {"i": PLACE, "j": PLACE, "value": NUMBER},
    "driver": {"driven": SCALAR, "law": LAW},
    "point_driver": {"on": PLACE, "letter": LETTER, "law": LAW},
    "relative_driver": {"i": PLACE, "j": PLACE, "letter": LETTER, "law": LAW},
    "rotation_driver": {"i": PLACE, "j": PLACE, "law": LAW},
    "translation_driver": {"i": PLACE, "j": PLACE, "law": LAW, "axis?": PAIR},
    "distance_driver": {"i": PLACE, "j": PLACE, "law": LAW},
    "cam_flat_follower": {"cam": CURVE, "face": PLACE, "axis?": PAIR},
    "cam_follower": {"cam": CURVE, "follower": CURVE},
    "point_follower": {"curve": CURVE, "point": PLACE},
    "curve_through": {"body": BODY, "points": POINTS, "closed?": FLAG},
    "contact": {
        "i": PLACE, "j": PLACE, "stiffness": NUMBER, "damping?": NUMBER, "free_length?": NUMBER,
        "direction?": PAIR, "may_pull?": FLAG, "fidelity?": _words("penalty", None),
    },
    "friction": {
        "joint": JOINT, "coefficient": NUMBER, "radius": NUMBER, "creep?": NUMBER,
        "fidelity?": _words("sticking", None),
    },
    "dry_friction": {
        "i": PLACE, "j": PLACE, "coefficient": NUMBER, "normal": NUMBER, "axis?": PAIR, "creep?": NUMBER
    },
    "track": {"point": PLACE},
    "alternatives": {"choices": CHOICES, "default?": _words("one", None)},
    "scene": {
        "effects?": Kind(lambda s, r: (), _bad_names), "drivers?": Kind(lambda s, r: [], _bad_names),
        "without?": NAMES, "start?": Kind(_states, _bad_mapping(["a.x", "a.phi"], of_number)),
        "guess?": Kind(_states, _bad_mapping(["a.x", "a.phi"], of_number)),
        "parameters?": Kind(lambda s, r: {s.k: 2}, _bad_mapping(["k"], of_number)),
        "frozen?": Kind(lambda s, r: r.choice([True, None]), lambda s, r: r.choice([1, "no", [], 0])),
        "analysis?": _words("dynamics", "kinematics", None),
        "fidelity?": Kind(_none, _bad_mapping(["pin"], of_number)),
        "couplers?": Kind(_none, _bad_mapping(["rod"], of_number)),
        "extends?": Kind(_none, lambda s, r: r.choice(["nothing", 7, s.a, object(), ["x"]])),
        "outputs?": Kind(
            lambda s, r: r.choice([None, ["energy"], "all", []]),
            lambda s, r: r.choice([7, ["nothing"], "energie", [7], {"a": 1}, [None], [["energy"]], object()]),
        ),
    },
}  # fmt: skip
"""Method of `Model` → its arguments, those that may be left out with a question mark."""

NO_NAME = ("depends_on",)
BAD_NAMES: list[Any] = [
    None, 7, "", "a b", "é", "a\nb", "class", "x" * 99, "a__b", "1a", b"abc", ["n"], object(), sympy.Symbol("n"),
    1.5, True, "ground", "pin", "\ud800", "n\n", ("n",), {"n"}, "import os\n", "n;import os",
]  # fmt: skip


def judge(random: Random) -> str | None:
    """What is wrong about the outcome of one case; None: nothing."""
    MARK.unlink(missing_ok=True)
    told: list[str] = []
    names: list[str] = []
    spoilt = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            scenery = Scenery(Model("m"))
            for k in range(random.choice([1, 1, 2])):
                about, bad, name = _call(scenery, random, k)
                told.append(about[0])
                names.append(name)
                spoilt += bad
                about[1]()
            if random.random() < 0.15:
                spoilt += _user_element(scenery, random, told, names)
            text = _build(scenery.model)
            fault = f"accepted: {told}" if spoilt else _text_fault(text)
        except LinkwrightError as error:
            fault = _error_fault(error, names)
        except Exception as error:
            fault = f"{_place(error)}: {type(error).__name__}: {str(error)[:300]}"
    if MARK.exists():
        return f"evaluated: {told}"
    return fault and f"{fault}\n    {told}"


def _call(scenery: Scenery, random: Random, k: int) -> tuple[tuple[str, Callable[[], Any]], int, str]:
    """(the call in words, the call), how many arguments are nonsense, the element's name."""
    method = random.choice(list(METHODS))
    kinds = {
        word.rstrip("?"): kind
        for word, kind in METHODS[method].items()
        if not word.endswith("?") or random.random() < 0.4
    }
    values = {word: kind.good(scenery, random) for word, kind in kinds.items()}
    odd = random.sample(list(values), min(len(values), random.choice([0, 1, 1, 1, 1, 2])))
    for word in odd:
        values[word] = kinds[word].bad(scenery, random)
    name: Any = f"e{k}"
    spoilt = len(odd)
    if method not in NO_NAME:
        if random.random() < 0.05:
            name, spoilt = random.choice(BAD_NAMES), spoilt + 1
        values = {"name": name, **values}
    shown = {w: v for w, v in values.items() if w in odd or w == "name"}
    words = f"{method}({', '.join(f'{w}={_short(v)}' for w, v in shown.items())}, ...)"
    written = name if isinstance(name, str) and name.isidentifier() else ""
    return (words, lambda: getattr(scenery.model, method)(**values)), spoilt, written


def _user_element(scenery: Scenery, random: Random, told: list[str], names: list[str]) -> int:
    """Add an element or a body of a modeller's own whose answers are nonsense."""
    make = hostile_body if random.random() < 0.2 else hostile_element
    element, about = make(scenery.model, scenery.a, random)
    told.append(about)
    names.append("mine")
    scenery.model.add(element)
    return 1


def _build(model: Model) -> str:
    """The texts of all scenes."""
    texts = []
    for scene in valid_scenes(model, None):
        lowered = lower(derive(model, scene))
        origin = Origin("fuzz", (), "0", "build(m)")
        texts.append(module_text(lowered, origin))
    return "\n".join(texts)


SAFE = (ast.Import, ast.Assign, ast.FunctionDef, ast.Expr)


def _text_fault(text: str) -> str | None:
    """What a generated module says that none says."""
    for node in ast.parse(text).body:
        if not isinstance(node, SAFE):
            return f"the module contains {ast.unparse(node)[:200]}"
        if isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant):
            return f"the module runs {ast.unparse(node)[:200]}"
        if isinstance(node, ast.Import) and {a.name for a in node.names} - {"math", "numba", "numpy"}:
            return f"the module imports {ast.unparse(node)[:200]}"
    return None


def _error_fault(error: LinkwrightError, names: list[str]) -> str | None:
    """What is wrong about an error of ours: it names no element, or is no sentence."""
    text = str(error)
    if not error.problems or not text.strip():
        return f"{_place(error)}: an error without words"
    for problem in error.problems:
        if "\n" in problem or len(problem) > 3000 or not problem.isprintable():
            return f"{_place(error)}: no printable sentence: {problem[:300]!r}"
    if not any(name and name in text for name in names) and all(names):
        return f"{_place(error)}: names no element: {text[:300]}"
    if " fails with " in text and "of the user's own" not in text and "its " not in text:
        return f"{_place(error)}: caught late: {text[:300]}"
    return None


def _place(error: BaseException) -> str:
    """Where an error was raised: the last line of ours, and the last of all."""
    while error.__cause__ is not None:
        error = error.__cause__
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/codegen/" in f.filename] or frames
    places = dict.fromkeys(f"{f.filename.rpartition('/')[2]}:{f.lineno}" for f in (ours[-1], frames[-1]))
    return " ".join(places)


def _short(value: Any) -> str:
    try:
        return ascii(value)[:120]
    except Exception:
        return f"a {type(value).__name__}"


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz declarations")
    parser.add_argument("--count", type=int, default=1000, help="cases")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds that a case may take")
    words = parser.parse_args()
    numbers = range(words.first, words.first + words.count)
    found = campaign.run("declarations", words.seed, numbers, words.limit, words.workers)
    sys.stdout.write(found.report())
    return 1 if found.findings else 0


if __name__ == "__main__":
    sys.exit(main())
