"""Conditions of a scene on its parameters: those of its elements, tables' ranges, cams' shapes."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass, replace
from typing import NamedTuple, cast

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import Constraint, Effect, Element, label
from codegen.declare.element_fields import Condition, derivatives, hold_conditions, sampled_profile
from codegen.declare.returned_values import (
    closed_curves,
    conditions_of,
    own_coordinates,
    statement_of,
)
from codegen.declare.scene import Scene
from codegen.declare.space_body import SpaceBody
from codegen.declare.symbols import Parameter, ParameterDeclaration, alpha, dotted, kinds, t
from codegen.derive.effect_terms import effect_terms
from codegen.elements.drivers import Driver
from codegen.elements.joints.cams import CamFollower
from codegen.parameter_conditions import ALPHAS, ProfileRow, roller_cut
from codegen.tables.table_function import Interpolant, plain_function

Numbers = Mapping[sympy.Symbol, float]
_ROUNDING = 1e-9  # accuracy: part of half the trace of an inertia; less beyond a bound is rounding


@dataclass(frozen=True)
class ElementCondition:
    """A condition, and the element that has it, as messages name it."""

    element: str
    condition: Condition


class Profile(NamedTuple):
    """A closed curve, x and y in alpha and parameters, and what is asked of it."""

    row: ProfileRow
    shape: sympy.Matrix

    @property
    def derivatives(self) -> tuple[sympy.Expr, ...]:
        """x, y and their first and second derivatives by α, which t stands for."""
        return tuple(e.subs(alpha, t) for e in derivatives(self.shape))


def expressions_in(part: object) -> Iterator[sympy.Basic]:
    """The expressions in nested tuples, lists, mappings and dataclasses."""
    stack = [part]
    while stack:
        part = stack.pop()
        if isinstance(part, sympy.Basic):
            yield part
        elif isinstance(part, tuple | list):
            stack += part
        elif isinstance(part, dict):
            stack += part.values()
        elif is_dataclass(part):
            stack += vars(part).values()


def element_conditions(element: Element, bodies: Bodies) -> list[ElementCondition]:
    """All conditions of an element that acts."""
    conditions = list(conditions_of(element))
    parts: object
    if isinstance(element, Constraint):
        statement = statement_of(element)
        parts = [tuple(statement.phi), dict(statement.bindings)]
    else:
        terms = effect_terms(cast(Effect, element), bodies)
        conditions += hold_conditions(terms.hold)
        parts = terms
    lookups = {node for e in expressions_in(parts) for node in e.atoms(Interpolant)}
    conditions += _ranges(sorted(lookups, key=str))
    return [ElementCondition(label(element), c) for c in conditions if not c.varies]


def outline_conditions(bodies: Bodies) -> list[ElementCondition]:
    """The conditions of the outlines of bodies, and of inertias in space that depend on parameters.

    J' is positive definite, and so, to rounding, is the matrix of second moments, ½ tr(J') I - J'.
    """
    found = [ElementCondition(f"{label(b)}: outline", c) for b in bodies for c in b.conditions]
    for body in (b for b in bodies if isinstance(b, SpaceBody)):
        if body.inertia is None or not body.inertia.free_symbols:
            continue
        j, half = body.inertia, body.inertia.trace() / 2
        text, other = "is not positive definite", "has a moment above the sum of the others"
        for k in (1, 2, 3):
            second = (half * sympy.eye(3) - j)[:k, :k].det() / half**k
            for fault, minor, low in (text, j[:k, :k].det(), None), (other, second, -_ROUNDING):
                sentence = f"it {fault} (minor {k} is {{:.3g}}); give other parameters."
                one = Condition(sentence, (minor,), low or 0.0, open=low is None)
                found.append(ElementCondition(f"{label(body)}: inertia", one))
    return found


def _ranges(lookups: list[Interpolant]) -> Iterator[Condition]:
    """Tables that are taken at parameters alone, within their ends."""
    for node in lookups:
        table, at = node.table, node.at
        if not table.periodic and kinds(at, Parameter):
            low, high = table.knots[0], table.knots[-1]
            text = (
                f"table '{table.name}' is taken at {at} = {{:g}}, outside of its points from "
                f"{low:g} to {high:g}."
            )
            yield Condition(text, (at,), low, False, high)


def profiles_of(
    element: Element, scene: Scene, drivers: Iterable[Element], numbers: Numbers
) -> list[Profile]:
    """The closed curves of a joint.

    All of a profile has to suit its roller where a driver turns one of the two round, else the part
    that a run uses.
    """
    of_contact: tuple[int, str] | tuple[()] = ()
    if isinstance(element, CamFollower):
        acting = (d for d in drivers if isinstance(d, Driver) and {*d.bodies} & {*element.bodies})
        turned = any(np.ptp(_known(driver.law.subs(numbers))) >= ALPHAS[-1] for driver in acting)
        given, own = dict((*scene.guess, *scene.start)), own_coordinates(element)
        coordinates = (*own, *(q for body in element.bodies for q in body.coordinates))
        places = {q: given.get(dotted(q), q.measure.neutral) for q in coordinates}
        inside = element.touches_inside({**numbers, **places})
        of_contact = -1 if inside else 1, "" if turned else element.name
    return [
        Profile(ProfileRow(where, convex, *(() if k else of_contact)), curve.at(alpha))
        for k, (where, curve, convex) in enumerate(closed_curves(element))
    ]


def _known(law: sympy.Expr) -> npt.NDArray[np.float64]:
    """Values of a law of motion at instants up to a quarter of an hour; 0 where it has none."""
    at = plain_function([t], [law])
    values = np.array([at([instant])[0] for instant in (0.0, *np.geomspace(1e-3, 1e3, 600))])
    return np.where(np.isfinite(values), values, 0.0)


def are_judged_in_runs(profiles: list[Profile], numbers: Numbers, varies: bool) -> bool:
    """Whether parameters that vary decide on the profiles of a joint, or the part that is used."""
    if varies and any(kinds(e, Parameter) for profile in profiles for e in profile.shape):
        return True
    if not (profiles and profiles[0].row.contact):
        return False
    cam, other = (sampled_profile(one.shape.subs(numbers).as_immutable()) for one in profiles)
    return roller_cut(cam, other, profiles[0].row.touches < 0) is not None


def carried(
    conditions: list[ElementCondition], parameters: tuple[ParameterDeclaration, ...],
    defaults: dict[sympy.Symbol, float],
) -> tuple[ElementCondition, ...]:  # fmt: skip
    """Those that other parameters may break, in terms of the `parameters` that take part.

    What the rule of a parameter's own sign implies is left out.
    """
    declared = {p.name: p for p in parameters}
    fixed = {symbol: value for symbol, value in defaults.items() if symbol.name not in declared}
    kept = {}
    for one in conditions:
        condition = one.condition
        numbers = tuple(number.subs(fixed) for number in condition.numbers)
        bound = replace(condition, numbers=numbers)
        if not bound.known and not bound.follows_from(declared):
            kept[one.element, bound] = ElementCondition(one.element, bound)
    return tuple(kept.values())
