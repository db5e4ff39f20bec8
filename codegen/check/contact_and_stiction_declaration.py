"""Checks of the sticking frictions and rigid contacts of a scene."""

from collections.abc import Iterator
from itertools import combinations

import sympy

from codegen.check.expressions import all_problems
from codegen.declare.element import Rigid, Sticking, label
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Parameter, Time, Velocity, kinds
from codegen.derive.effect_terms import effect_terms
from codegen.derive.switching_functions import Named, switches
from codegen.model import Model

Numbers = dict[sympy.Symbol, float]
# accuracy: difference of two ratios of friction coefficients that rounding explains
ROUNDING = 1e-12


def contact_problems(model: Model, scene: Scene) -> list[str]:
    """Check the numbers that parameters give, and surfaces that two effects share."""
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    chosen = [] if scene.analysis == "kinematics" else list(model.acting(scene).values())
    named = [(effect.name, effect_terms(effect, bodies)) for effect in chosen]
    if not any(terms.hold for _, terms in named):
        return []
    overrides = {Parameter(name, real=True): value for name, value in scene.parameters}
    numbers = model.defaults | overrides
    problems: list[str] = []
    for effect, (_, terms) in zip(chosen, named, strict=True):
        where = f"scene '{scene.name}': {label(effect)}"
        if isinstance(terms.hold, Sticking):
            problems += _friction(where, terms.hold, numbers)
        elif isinstance(terms.hold, Rigid):
            problems += _contact(where, terms.hold, numbers)
    return [*problems, *_shared(scene, named)]


def _friction(where: str, hold: Sticking, numbers: Numbers) -> Iterator[str]:
    for word, value in (("coefficient", hold.kinetic), ("static coefficient", hold.static)):
        if value is not None and kinds(value, Coordinate, Velocity, Time):
            yield (
                f"{where}: the {word} {value} varies in a run; a friction that sticks takes "
                "numbers and parameters: give creep= for one that varies."
            )
            return
    if hold.static is None:
        return
    kinetic, static = (float(e.subs(numbers)) for e in (hold.kinetic, hold.static))
    if static < kinetic:
        yield (
            f"{where}: the static coefficient {hold.static} is {static:g}, below the kinetic one, "
            f"{hold.kinetic} = {kinetic:g}; give parameters with which it is not."
        )


def _contact(where: str, hold: Rigid, numbers: Numbers) -> Iterator[str]:
    for word, value in (("restitution", hold.restitution), ("typical force", hold.scale)):
        if kinds(value, Coordinate, Velocity, Time):
            yield f"{where}: the {word} {value} varies in a run; give a number or parameters."
            return
    e, scale = (float(x.subs(numbers)) for x in (hold.restitution, hold.scale))
    if not 0 <= e <= 1:
        yield (
            f"{where}: the restitution {hold.restitution} is {e:g}; give parameters with which it "
            "is from 0 (no rebound) to 1 (no loss)."
        )
    if not scale > 0:
        yield f"{where}: the typical force {hold.scale} is {scale:g} N; make it positive."
    yield from all_problems(where, [hold.gap], may_switch=False)


def _shared(scene: Scene, named: list[Named]) -> Iterator[str]:
    """Switching surfaces of two effects whose forces one share α cannot determine."""
    every = [(name, switch) for name, terms in named for switch in switches([(name, terms)])]
    for (first, one), (second, other) in combinations(every, 2):
        if other.g not in (one.g, -one.g):
            continue
        where = f"scene '{scene.name}': '{first}' and '{second}'"
        if one.kind == other.kind == "contact":
            yield (
                f"{where} are contacts at the same gap {one.g}, whose reactions no motion "
                "distinguishes; leave one of them out."
            )
        elif "contact" not in (one.kind, other.kind) and not _equal(one.ratio, other.ratio):
            holder = first if one.ratio is not None else second
            yield (
                f"{where} both change where {one.g} = 0, and '{holder}' has a static coefficient, "
                "which applies to both; leave static= out, or give both frictions the same "
                "coefficients."
            )


def _equal(one: sympy.Expr | None, other: sympy.Expr | None) -> bool:
    """Whether two ratios are the same, but for the rounding of their numbers."""
    difference = (sympy.S.One if one is None else one) - (sympy.S.One if other is None else other)
    return bool(difference == 0 or (difference.is_number and abs(difference) < ROUNDING))
