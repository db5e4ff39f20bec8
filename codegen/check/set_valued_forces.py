"""Checks of the sticking frictions, rigid contacts and freewheels of a scene."""

from collections.abc import Iterator
from itertools import combinations

import sympy

from codegen.check.expressions import all_problems
from codegen.declare.element import OneWay, Rigid, Sticking, label
from codegen.declare.element_conditions import ROUNDING
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Time, Velocity, kinds
from codegen.derive.effect_terms import effect_terms
from codegen.derive.switching_functions import Named, switches
from codegen.model import Model


def contact_problems(model: Model, scene: Scene) -> list[str]:
    """Check that what must not vary does not, and surfaces that two effects share."""
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    chosen = [] if scene.analysis == "kinematics" else list(model.acting(scene).values())
    named = [(effect.name, effect_terms(effect, bodies)) for effect in chosen]
    if not any(terms.hold for _, terms in named):
        return []
    problems: list[str] = []
    for effect, (_, terms) in zip(chosen, named, strict=True):
        where = f"scene '{scene.name}': {label(effect)}"
        if isinstance(terms.hold, Sticking):
            problems += _friction(where, terms.hold)
        elif isinstance(terms.hold, Rigid):
            problems += _contact(where, terms.hold)
        elif isinstance(terms.hold, OneWay) and kinds(terms.hold.scale, Coordinate, Velocity, Time):
            problems.append(
                f"{where}: the typical torque {terms.hold.scale} varies in a run; give a number "
                "or parameters."
            )
    return [*problems, *_shared(scene, named)]


def _friction(where: str, hold: Sticking) -> Iterator[str]:
    for word, value in (("coefficient", hold.kinetic), ("static coefficient", hold.static)):
        if value is not None and kinds(value, Coordinate, Velocity, Time):
            yield (
                f"{where}: the {word} {value} varies in a run; a friction that sticks takes "
                "numbers and parameters: give creep= for one that varies."
            )
            return


def _contact(where: str, hold: Rigid) -> Iterator[str]:
    for word, value in (("restitution", hold.restitution), ("typical force", hold.scale)):
        if kinds(value, Coordinate, Velocity, Time):
            yield f"{where}: the {word} {value} varies in a run; give a number or parameters."
            return
    yield from all_problems(where, [hold.gap], may_switch=False)


def _shared(scene: Scene, named: list[Named]) -> Iterator[str]:
    """Switching surfaces of two effects whose forces one share α cannot determine."""
    every = [(name, switch) for name, terms in named for switch in switches([(name, terms)])]
    for (first, one), (second, other) in combinations(every, 2):
        if other.g not in (one.g, -one.g):
            continue
        if "clutch" in (one.kind, other.kind):
            if one.kind == other.kind and one.g == other.g:
                yield (
                    f"scene '{scene.name}': '{first}' and '{second}' are freewheels of one slip "
                    f"{one.g}, whose torques no motion distinguishes; leave one of them out."
                )
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
