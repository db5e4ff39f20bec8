"""Elements and bodies of a modeller's own whose answers mean nothing."""

from random import Random
from typing import Any

import sympy

from codegen import ConjugateReaction, Constraint, Effect, JointReaction, Model, Statement, t
from codegen.declare.body import Body
from codegen.declare.element import FrictionLaw, I, Rigid, Sticking
from codegen.declare.element_conditions import Condition
from codegen.declare.symbols import SPEED, coordinate
from codegen.errors import FAILURES
from codegen.plain_values import shown
from tests.fuzz.declared_nonsense import CODE, Raises, of_object, of_scalar


def _raise(*_: Any) -> Any:
    raise KeyError("of the user's own")


class _Joint(Constraint):
    kind = "own joint"

    def __init__(self, name: Any, body: Body, **answers: Any) -> None:
        self.name, self.body, self.answers = name, body, answers
        if "near" in answers:
            place = coordinate("mine", "alpha")
            phi = (body.x - sympy.cos(place), body.y - place)
            own = (("along", place),)
            self.answers["statement"] = lambda: Statement(phi, ("x", "along"), None, own=own)
        for word in ("conditions", "profiles", "near"):
            if word in answers:
                answer = answers[word]
                setattr(self, word, answer if answer is _raise else lambda *_, a=answer: a)
        if "instead_of" in answers:
            self.instead_of = answers["instead_of"]

    @property
    def bodies(self) -> Any:
        answer = self.answers.get("bodies", (self.body,))
        return answer() if answer is _raise else answer

    def problems(self) -> Any:
        answer = self.answers.get("problems", [])
        return answer() if answer is _raise else answer

    def statement(self) -> Any:
        answer = self.answers.get("statement", lambda: _statement(self.body))
        return answer() if callable(answer) else answer


class _Force(Effect):
    kind = "own force"

    def __init__(self, name: Any, body: Body, **answers: Any) -> None:
        self.name, self.body, self.answers = name, body, answers
        for word in ("friction", "hold", "pulls", "reported", "conditions", "weights"):
            if word in answers:
                setattr(self, word, lambda *_, word=word: self._answer(word, None))

    def _answer(self, word: str, otherwise: Any) -> Any:
        answer = self.answers.get(word, otherwise)
        return answer() if answer is _raise else answer

    @property
    def bodies(self) -> Any:
        return self._answer("bodies", (self.body,))

    def problems(self) -> Any:
        return self._answer("problems", [])

    def forces(self, bodies: Any) -> Any:
        return self._answer("forces", {self.body.x: sympy.Integer(1)})

    def potential(self, bodies: Any) -> Any:
        return self._answer("potential", None)


def _statement(body: Body, **changes: Any) -> Any:
    words: dict[str, Any] = {
        "phi": (body.x - 1,),
        "rows": ("x",),
        "reaction": ConjugateReaction((("fx", "N"),)),
        "bindings": {},
        "own": (),
    }
    return Statement(**(words | changes))


def hostile_element(model: Model, body: Body, random: Random) -> tuple[Any, str]:
    """An element with one answer that means nothing, and which."""
    odd = _odd(random)
    if random.random() < 0.4:
        word, answer = random.choice(_of_joints(body, odd, random))
        about = f"joint {word}: {_text(answer)}"
        if word == "name":
            return _Joint(answer, body), about
        return _Joint("mine", body, **{word: answer}), about
    word, answer = random.choice(_of_forces(body, odd, random))
    about = f"force {word}: {_text(answer)}"
    if word == "name":
        return _Force(answer, body), about
    return _Force("mine", body, **{word: answer}), about


def _text(answer: Any) -> str:
    return ascii(shown(answer))[1:101]


def _odd(random: Random) -> Any:
    """An answer that is of no kind that an element answers."""
    while True:
        odd = of_object(random)
        if odd is not None and not callable(odd) and not _is_empty(odd):
            return odd


def _is_empty(odd: Any) -> bool:
    try:
        return len(odd) == 0
    except FAILURES:
        return False


def _of_joints(body: Body, odd: Any, random: Random) -> list[tuple[str, Any]]:
    scalar = of_scalar(random, lambda: None)
    return [
        ("bodies", odd),
        ("bodies", _raise),
        ("bodies", (7,)),
        ("bodies", None),
        ("problems", odd if not {*type.mro(type(odd))} & {list, tuple} else 7),
        ("problems", _raise),
        ("problems", None),
        ("problems", [7]),
        ("statement", _raise),
        ("statement", odd),
        ("name", odd),
        ("name", None),
        *((word, answer) for word in ("conditions", "profiles") for answer in (odd, _raise, 7)),
        ("near", odd),
        ("near", _raise),
        ("near", {coordinate("mine", "alpha"): odd}),
        ("instead_of", odd),
        # Any text is a sentence.
        ("conditions", (Condition(7 if issubclass(type(odd), str) else odd, (body.x,)),)),
        ("conditions", (Condition("{:g}", (sympy.S.One,), low=odd),)),
        ("conditions", (Condition("{:g}", odd),)),
        ("statement", lambda: _statement(body, phi=(1,))),
        ("statement", lambda: _statement(body, own=(("x", coordinate("a", "x")),))),
        ("statement", lambda: None),
        ("statement", Raises),
        ("statement", lambda: _statement(body, phi=(scalar,))),
        ("statement", lambda: _statement(body, phi=body.x)),
        ("statement", lambda: _statement(body, phi=())),
        ("statement", lambda: _statement(body, rows=())),
        ("statement", lambda: _statement(body, rows=(f"x\n{CODE}",))),
        ("statement", lambda: _statement(body, rows=7)),
        ("statement", lambda: _statement(body, reaction=odd)),
        ("statement", lambda: _statement(body, reaction=ConjugateReaction((("f\n" + CODE, "N"),)))),
        ("statement", lambda: _statement(body, reaction=ConjugateReaction((("f", "N\n"),)))),
        ("statement", lambda: _statement(body, reaction=ConjugateReaction(7))),  # type: ignore[arg-type]
        ("statement", lambda: _statement(body, reaction=JointReaction(odd))),
        ("statement", lambda: _statement(body, reaction=JointReaction(sympy.Matrix([1, 0]), on=7))),  # type: ignore[arg-type]
        ("statement", lambda: _statement(body, bindings=odd)),
        ("statement", lambda: _statement(body, bindings={I.x: scalar})),
        ("statement", lambda: _statement(body, bindings={7: 1})),
        ("statement", lambda: _statement(body, own=odd)),
        ("statement", lambda: _statement(body, own=(("x", 7),))),
        ("statement", lambda: _statement(body, own=(("z", coordinate("mine", "alpha")),))),
        ("statement", lambda: Statement(7, 7, 7, 7, 7)),  # type: ignore[arg-type]
    ]


def _of_forces(body: Body, odd: Any, random: Random) -> list[tuple[str, Any]]:
    scalar = of_scalar(random)
    return [
        ("bodies", odd),
        ("bodies", _raise),
        ("problems", _raise),
        ("problems", 7),
        ("problems", "text"),
        ("forces", odd),
        ("forces", _raise),
        ("forces", None),
        ("forces", {body.x: scalar}),
        ("forces", {"a.x": 1}),
        ("forces", {7: 1}),
        ("forces", [(body.x, 1)]),
        ("forces", {body.vx: 1}),
        ("potential", scalar),
        ("potential", _raise),
        ("potential", "m g h"),
        ("potential", body.vx),
        ("pulls", odd),
        ("pulls", _raise),
        ("pulls", ((1, 2, 3),)),
        ("pulls", ((body.x, "s" if scalar is SPEED else scalar),)),
        ("hold", odd),
        ("hold", _raise),
        ("hold", 7),
        ("friction", odd),
        ("friction", _raise),
        ("reported", odd),
        ("reported", _raise),
        ("reported", ((f"f\n{CODE}", "N", body.x),)),
        ("reported", (("f", f"N\n{CODE}", body.x),)),
        ("reported", (("f", "N", scalar),)),
        ("reported", (("f", 7, body.x),)),
        ("reported", ((None, "N", body.x),)),
        ("reported", 7),
        *((word, answer) for word in ("conditions", "weights") for answer in (odd, _raise, 7)),
        ("reported", ((property(lambda s: 1), "N", body.x),)),
        ("name", odd),
        ("name", None),
        ("friction", FrictionLaw("nothing", scalar, None, body.x, (), "N")),
        ("friction", FrictionLaw(7, 1, None, body.x, (), "N")),  # type: ignore[arg-type]
        ("friction", FrictionLaw("pin", sympy.S.One, None, body.x, 7, "N")),  # type: ignore[arg-type]
        ("hold", Sticking(scalar, sympy.S.One)),
        ("hold", Rigid(scalar, sympy.S.One, sympy.S.One)),
        ("hold", Rigid(body.x, sympy.S.One, scalar)),
        ("hold", Sticking(body.vx, 7, "x")),  # type: ignore[arg-type]
    ]


def hostile_body(model: Model, body: Body, random: Random) -> tuple[Any, str]:
    """A body of an own class with one answer that means nothing."""
    word = random.choice(
        [
            "coordinates",
            "position",
            "rotation",
            "angle",
            "angular_velocity",
            "mass_matrix",
            "inertia_force",
            "equations",
            "torque",
            "velocity",
            "mass_centre",
            "turns",
            "fixed",
            "name",
            "mass",
            "inertia",
        ]
    )
    answer = random.choice(
        [_odd(random), of_scalar(random), 7, "x", (1,), {7: 1}, t > 1, None, _raise]
    )
    may_be_none = ("angle", "mass", "inertia")
    while (word in may_be_none and answer is None) or (
        word in ("turns", "fixed") and type(answer) is bool
    ):
        answer = 7.5j
    if word == "name":
        good = type(answer) is str and answer.isidentifier()
        answer = 7 if good or answer is _raise else answer
        return Body(answer, sympy.S.One, sympy.S.One, model.token), "body name"
    if word in ("mass", "inertia"):
        values = {
            "mass": sympy.S.One,
            "inertia": sympy.S.One,
            word: answer if answer is not _raise else 7j,
        }
        return Body("mine", model=model.token, **values), f"body {word}: {_text(answer)}"
    if word == "torque":
        space: dict[str, Any] = {word: lambda self, value: _raise() if answer is _raise else answer}
    else:
        space = {word: property(lambda self: _raise() if answer is _raise else answer)}
    made = type("Mine", (Body,), space)
    return made("mine", sympy.S.One, sympy.S.One, model.token), f"body {word}: {_text(answer)}"
