"""Public callables and attributes of a declaration, used in ways that mean nothing.

Wrong numbers of arguments, what is declared set anew, points and curves made by hand, scenes varied
or changed by hand, parts of another model: each misuse is a call that must be refused at once, or,
where it is `late`, by the checks of the model.
"""

from collections.abc import Callable
from dataclasses import fields, replace
from random import Random
from typing import Any, NamedTuple

import codegen
from codegen import Curve, I, Model, Point, Scene, Statement, coordinate, element, given, t
from codegen.plain_values import finite_float, is_a, is_flag, shown
from codegen.reading.scene_selection import valid_scenes, with_settings
from tests.fuzz.declared_arguments import Scenery, is_pair
from tests.fuzz.declared_methods import METHODS
from tests.fuzz.declared_nonsense import of_object, of_scalar

ROLES = {"kind": 1, "acting": 1, "recompose": 1, "choice": 3, "place_of": 2, "varied": 1}
"""Methods of a model that tell what is declared → the most positional arguments."""


class Misuse(NamedTuple):
    """A call in words, the call, a name that its error must say, and whether it may be right."""

    words: str
    call: Callable[[], Any]
    name: str
    may_be_right: bool = False


def misuse(s: Scenery, random: Random) -> Misuse:
    """One of all kinds."""
    return random.choice(KINDS)(s, random)


def _callables(s: Scenery) -> list[tuple[str, Callable[..., Any], int]]:
    """(name, callable, the most positional arguments that it takes)."""
    scene = s.model.scene("s0") if "s0" not in s.model.scenes else s.model.scenes["s0"]
    methods = [(name, getattr(s.model, name), len(words) + 1) for name, words in METHODS.items()]
    return [
        *((name, call, 99 if name in ("constraint",) else 16) for name, call, _ in methods),
        *((f"body.{n}", getattr(s.a, n), 2) for n in ("at", "curve", "circle", "polar")),
        ("Model", Model, 2), ("Point", Point, 3), ("Curve", Curve, 4), ("Statement", Statement, 5),
        ("body", codegen.Body, 4), ("scene", Scene, 0), ("coordinate", coordinate, 2),
        ("given", given, 1), ("element", element, 1), ("table", s.law, 1),
        ("scene", scene.with_, 99),
        ("model.add", s.model.add, 1), ("curve", s.a.circle(1).at, 1), ("frame", I.bind, 1),
        ("ConjugateReaction", codegen.ConjugateReaction, 1), ("build", codegen.build, 3),
        ("JointReaction", codegen.JointReaction, 4), ("model.scene", s.model.scene, 3),
        *((f"model.{n}", getattr(s.model, n), k) for n, k in ROLES.items()),
    ]  # fmt: skip


def _wrong_arity(s: Scenery, random: Random) -> Misuse:
    name, call, most = random.choice([c for c in _callables(s) if c[2] < 99])
    arguments = [of_object(random) for _ in range(random.choice([0, 1, 2, 3]))]
    words: dict[str, Any] = {}
    if random.random() < 0.4:
        arguments += [of_object(random)] * (most + 1 - len(arguments))
    else:
        word = random.choice(["foo", "Name", "self", "x1", "__class__", "a b", "mas", "\n"])
        words[word] = of_object(random)
    about = f"{name} with {len(arguments)} arguments and {list(words)!a}"
    return Misuse(about, lambda: call(*arguments, **words), name.rpartition(".")[2])


def _anything(s: Scenery, random: Random) -> Misuse:
    """A callable with as many arguments as it may take, of any kind."""
    name, call, most = random.choice(_callables(s))
    arguments = [of_object(random) for _ in range(random.randint(0, min(most, 5)))]
    about, title = f"{name} with {len(arguments)} of anything", name.rpartition(".")[2]
    title = "" if name == "build" else title  # of a file that is not there it says the path
    return Misuse(about, lambda: call(*arguments), title, may_be_right=True)


def _owners(s: Scenery) -> list[tuple[str, Any]]:
    scene = s.model.scenes.get("s1") or s.model.scene("s1")
    statement = s.pin.statement()
    return [
        ("m", s.model), ("a", s.a), ("p", s.p), ("ground", s.model.ground), ("s1", scene),
        ("Point", s.a.at(1, 0)), ("Curve", s.a.circle(1)), ("pin", s.pin), ("Frame", I),
        ("Statement", statement), ("a_x", s.a.x), ("a_vx", s.a.vx), ("k", s.k), ("t", t),
    ]  # fmt: skip


def _set_or_deleted(s: Scenery, random: Random) -> Misuse:
    """What is declared is set or deleted, or a word is asked for that there is not."""
    name, owner = random.choice(_owners(s))
    public = [w for w in dir(type(owner)) if not w.startswith("_") and _is_data(owner, w)]
    public += [w for w in vars(owner) if not w.startswith("_")]
    word, value = random.choice(sorted({*public})), of_object(random)
    if random.random() < 0.3:
        return Misuse(f"del {name}.{word}", lambda: delattr(owner, word), word)
    return Misuse(f"{name}.{word} = ...", lambda: setattr(owner, word, value), word)


def _is_data(owner: Any, word: str) -> bool:
    return not callable(getattr(type(owner), word, None))


def _table_written(s: Scenery, random: Random) -> Misuse:
    word = random.choice(["bodies", "joints", "drivers", "effects", "parameters", "scenes"])
    table, value = getattr(s.model, word), of_object(random)
    calls: list[Callable[[], Any]] = [
        lambda: table.__setitem__("z", value), lambda: table.__delitem__("a"), table.clear,
        lambda: table.update(z=value), lambda: table.setdefault("z", value),
        lambda: table.pop("a"), table.popitem, lambda: table.__ior__({"z": value}),
    ]  # fmt: skip
    return Misuse(f"{word} written to", random.choice(calls), word)


def _by_hand(s: Scenery, random: Random) -> Misuse:
    """A point or curve made by hand, asked where it is or taken hold of."""
    odd, fine = of_scalar(random, lambda: None), random.choice([1.0, s.k, 0])
    pair = random.choice([(odd, fine), (fine, odd), (odd, odd)])
    body = random.choice([s.a, s.p, s.model.ground, s.other])
    if random.random() < 0.5:
        point = random.choice([lambda: Point(body, *pair), lambda: body.at(*pair)])
        word = random.choice(["x", "y", "vx", "vy", "own_velocity", "place"])
        use = lambda: getattr(point(), word)  # noqa: E731
        return Misuse(f"point.{word} of {_shown(pair)}", use, "point", may_be_right=True)
    if random.random() < 0.3:
        odd_body = of_object(random)
        word = random.choice(["x", "vx"])
        use = lambda: getattr(Point(odd_body, 0, 0), word)  # noqa: E731
        return Misuse(f"Point({_shown(odd_body)}, 0, 0).{word}", use, "point")
    curve = random.choice([lambda: Curve(body, *pair), lambda: body.curve(*pair)])
    at = random.choice([0.5, of_scalar(random)])
    use = lambda: curve().at(at)  # noqa: E731
    return Misuse(f"curve {_shown(pair)} at {_shown(at)}", use, "curve", may_be_right=True)


def _scene(s: Scenery) -> Scene:
    if "s2" not in s.model.scenes:
        s.model.force("f2", on=s.a, fx=1.0)
        s.model.scene("s2", effects=["f2"])
    return s.model.scenes["s2"]


def _varied(s: Scenery, random: Random) -> Misuse:
    """A scene with elements left out or taken in that are none, or words that are none."""
    scene, odd = _scene(s), of_object(random)
    word = random.choice(["start", "guess", "parameters", "frozen", "analysis", "outputs"])
    changes = {word: odd}
    calls: list[tuple[str, Callable[[], Any]]] = [
        ("without", lambda: scene.without(odd)),
        ("with_", lambda: scene.with_(odd)),
        ("with_", lambda: scene.with_("f2", fidelity=odd)),
        ("with_", lambda: scene.with_(**changes)),
        ("with_", lambda: scene.with_(nonsense=odd)),
    ]
    verb, call = random.choice(calls)
    use = lambda: valid_scenes(s.model, call())  # type: ignore[arg-type]  # noqa: E731
    empty = odd is None or _is_empty(odd)
    return Misuse(f"{verb} {word} {_shown(odd)}", use, "s2", may_be_right=empty or word == "frozen")


def _changed(s: Scenery, random: Random) -> Misuse:
    """A scene that is changed by hand."""
    scene, odd = _scene(s), of_object(random)
    word = random.choice([f.name for f in fields(Scene)])
    use = lambda: valid_scenes(s.model, replace(scene, **{word: odd}))  # noqa: E731
    empty = odd is None or _is_empty(odd) or (word == "frozen" and is_flag(odd))
    named = word == "name" and type(odd) is str and odd.isidentifier()
    right = empty or named or word in ("expression", "problems", "owner")
    of = "" if word == "problems" else "scene"  # what stands in problems is the answer
    return Misuse(f"scene with {word}={_shown(odd)}", use, of, may_be_right=right)


def _chosen(s: Scenery, random: Random) -> Misuse:
    """What is no scene is built, or with settings that are none."""
    odd, scene = of_object(random), _scene(s)
    if random.random() < 0.5:
        words = random.choice([{"scene": odd}, {"scene": [scene, odd]}, {"settings": odd}])
        words |= {"check": True}
        if random.random() < 0.5:
            words = {
                random.choice(["out", "tangents", "reduced", "check", "compile", "progress"]): odd
            }
            words = {"check": True, "compile": False, "scene": "no"} | words
        use = lambda: codegen.build(s.model, **words)  # noqa: E731
        return Misuse(f"build with {list(words)} {_shown(odd)}", use, "", may_be_right=True)
    use = lambda: with_settings(s.model, {"k": odd})  # noqa: E731
    right = finite_float(odd) is not None
    return Misuse(f"settings of {_shown(odd)}", use, "'k'", right)


def _model(s: Scenery, random: Random) -> Misuse:
    odd = of_object(random)
    words = random.choice(
        [{"name": odd}, {"name": "m", "gravity": odd}, {"name": "m", "gravity": (0, odd)}]
    )

    def use() -> None:
        model = Model(**words)
        model.particle("p", mass=1.0)
        valid_scenes(model, None)

    right = is_pair(odd) if words.get("gravity") is odd else finite_float(odd) is not None
    right |= odd is t  # a frame that moves
    if words.get("gravity") is None:
        right = _is_name(words["name"])
    return Misuse(
        f"Model of {_shown(odd)}", use, "model" if "gravity" not in words else "gravity", right
    )


def _foreign(s: Scenery, random: Random) -> Misuse:
    """A part of another model, used in this one."""
    other = Model("other")
    body, k = other.body("a", 1.0, 1.0), other.parameter("kk", 1.0)
    joint = other.revolute("pin", other.ground.at(0, 0), body.at(1, 0))
    effect = other.force("push", on=body, fx=1.0)
    m = s.model
    uses: list[Callable[[], Any]] = [
        lambda: m.force("e", on=body, fx=1.0), lambda: m.revolute("e", m.ground, body.at(0, 0)),
        lambda: m.friction("e", joint, 0.1, radius=0.1, creep=0.1),
        lambda: m.scene("e", without=[body]), lambda: m.scene("e", effects=[effect]),
        lambda: m.torque("e", on=s.b, value=k), lambda: m.scene("e", parameters={k: 1.0}),
        lambda: m.track("e", body), lambda: m.add(effect), lambda: m.add(joint),
        lambda: m.alternatives("e", {"one": [joint], "two": []}), lambda: m.cam_follower(
            "e", body.circle(1), s.b.circle(1)), lambda: m.spring("e", body, s.b, damping=1.0),
        lambda: m.torsion_spring("e", other.ground, s.b, damping=1.0),
        lambda: m.absolute("e", body.at(0, 1), "x", 1.0), lambda: m.driver("e", s.b.x, k),
    ]  # fmt: skip
    use = random.choice(uses)

    def built() -> None:
        use()
        valid_scenes(m, None)

    return Misuse(f"foreign {uses.index(use)}", built, "")


def _shown(value: Any) -> str:
    return ascii(shown(value))[1:81]


def _is_name(value: Any) -> bool:
    return is_a(value, str) and str.isidentifier(value)


def _is_empty(value: Any) -> bool:
    """Whether it lists or says nothing."""
    try:
        return len(value) == 0
    except BaseException:
        return False


KINDS = (
    *(_wrong_arity, _anything, _anything, _set_or_deleted, _table_written, _by_hand, _by_hand),
    *(_varied, _changed, _chosen, _model, _foreign),
)
