"""Switching functions of a scene: conditions, frictions that stick, contacts, freewheels."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import sympy
from sympy.core.relational import Relational

from codegen.declare.element import OneWay, Rigid, Sticking
from codegen.declare.symbols import (
    Acceleration,
    Coordinate,
    Side,
    Velocity,
    alpha,
    derivative,
    kinds,
    side,
    t,
)
from codegen.derive.effect_terms import EffectTerms
from codegen.derive.piecewise_conditions import Boundary, boundary, conditions, switching_function
from codegen.readers.calls import errors_at
from codegen.readers.values import label_sides
from codegen.tables.branches import knot_function, knots_function
from codegen.tables.piecewise_function import ClosedPieces
from codegen.tables.table_function import Interpolant, TableAtom

Named = tuple[str, EffectTerms]
Bindings = Mapping[sympy.Symbol, sympy.Expr]
TURN = 2.0 * math.pi  # formula: after which a profile repeats, rad


@dataclass(frozen=True)
class Switch:
    """A switching function g of an effect and its rate dg/dt along the motion."""

    effect: str  # the first effect that switches there
    text: str  # the condition that holds where g > 0
    g: sympy.Expr
    rate: sympy.Expr
    # A "friction" holds g = 0 by forces between those of both modes, a "contact" and a "clutch" by
    # a reaction; all else is a "condition".
    kind: Literal["condition", "friction", "contact", "clutch"] = "condition"
    ratio: sympy.Expr | None = None  # of a friction: μ_s/μ, where it is not 1
    boundary: Boundary = Boundary.OPEN  # what holds where the motion stays on g = 0

    @property
    def alone(self) -> bool:
        """Whether a reaction scales the force of this effect alone."""
        return self.kind in ("contact", "clutch")

    @property
    def at_zero(self) -> str:
        """A word on a condition that is more than g > 0; empty for others, and friction alone."""
        if role := table_role(self.g):
            return role
        kinds = {Boundary.MIXED} if self.kind == "friction" else {*Boundary} - {Boundary.OPEN}
        return self.boundary.name.lower() if self.boundary in kinds - {Boundary.INDIFFERENT} else ""


@dataclass(frozen=True)
class SideValue:
    """The number `symbol` is `above` in mode 1 of a switch and `below` in mode 0."""

    symbol: Side
    switch: int
    above: int
    below: int


@dataclass(frozen=True)
class RigidContact:
    """A rigid contact in a scene, by its name and the number of its switch."""

    effect: str
    switch: int
    moving: bool  # whether the gap depends on the time, so that the contact does work
    acceleration: sympy.Expr  # d²g/dt² along the motion
    restitution: sympy.Expr  # e
    scale: sympy.Expr  # F0, N: the reaction of mode 0


def table_role(g: sympy.Expr) -> str:
    """Of a function that a table switches with "knots" or "range"; empty of all others."""
    role = g.table.role if isinstance(g, Interpolant) else "values"
    return role if role in ("knots", "range") else ""


def table_text(g: Interpolant) -> str:
    """A switching function of a table in words, as events name it."""
    table = g.table
    if table.role == "knots":
        return f"knots of table '{table.name}' at {g.at}"
    return f"{g.at} in the range of table '{table.name}', {table.first:g} to {table.last:g}"


@cache
def rate(g: sympy.Expr) -> sympy.Expr:
    """dg/dt = g_t + g_q q̇ + g_q̇ q̈."""
    terms = [derivative(g, t)]
    terms += [derivative(g, q) * q.rate for q in kinds(g, Coordinate)]
    for v in kinds(g, Velocity):
        terms.append(derivative(g, v) * Acceleration(f"{v.name}_rate", real=True))
    return sympy.Add(*terms)


def switches(effects: Sequence[Named]) -> tuple[Switch, ...]:
    """The switching functions of the effects of a scene, (name, terms) each.

    One switch a condition: a condition and its opposite share it, and so does a friction whose
    slip changes sign with them. Contacts and freewheels have their own, since a reaction scales
    their force alone.
    """
    contacts, others = list[Switch](), list[Switch]()
    for name, terms in effects:
        with errors_at(f"'{name}'"):
            hold = terms.hold
            if isinstance(hold, Rigid):
                g = hold.gap
                contacts.append(Switch(name, f"{g} > 0", g, rate(g), "contact"))
            elif isinstance(hold, OneWay):
                g = hold.slip
                others.append(Switch(name, f"{g} > 0", g, rate(g), "clutch"))
            elif isinstance(hold, Sticking) and _same(hold.slip, others) is None:
                g = hold.slip
                ratio = None if hold.static is None else hold.static / hold.kinetic
                law = Boundary.BALANCED  # as a sign
                others.append(Switch(name, f"{g} > 0", g, rate(g), "friction", ratio, law))
    for name, terms in effects:
        with errors_at(f"'{name}'"):
            for condition in _conditions(terms):
                g, at_zero = switching_function(condition), boundary(condition)
                found = find_switch(g, at_zero, others)
                if found is None:
                    text = table_text(g) if table_role(g) else str(condition)
                    others.append(Switch(name, text, g, rate(g), boundary=at_zero))
                else:
                    switch, own = others[found[0]], at_zero.of_opposite() if found[1] else at_zero
                    others[found[0]] = replace(switch, boundary=switch.boundary.joined_with(own))
    return (*contacts, *others)


def profile_knots(parts: Iterable[tuple[str, Iterable[sympy.Expr], Bindings]]) -> Iterator[Switch]:
    """Where pieces of a profile or another function of coordinates meet: steps of a run end.

    Nothing switches there. `parts` are the expressions of elements, with what stands for symbols.
    """
    for name, expressions, bindings in parts:
        found = dict[sympy.Expr, set[float]]()
        for pieces in sorted(sympy.Tuple(*expressions).atoms(ClosedPieces), key=str):
            meetings = sorted(pieces.args[0].expression.atoms(Relational), key=str)
            places = {own: place.xreplace(bindings) for own, place in pieces.places.items()}
            if alpha not in places:
                placed = (c.xreplace(places) for c in meetings)
                for g in (switching_function(c) for c in placed if c.has(Coordinate)):
                    if -g not in found:
                        found[g] = set()
                continue
            if not (at := places[alpha]).has(Coordinate):
                continue
            for g in (c.lhs - c.rhs for c in meetings):
                slope, rest = g.diff(alpha), g.subs(alpha, 0)
                if slope.is_number and rest.is_number and slope != 0:
                    found.setdefault(at, {0.0}).add(float(-rest / slope) % TURN)
        for at, knots in found.items():
            table = knots_function(name, sorted(knots), TURN) if knots else knot_function(name)
            g = Interpolant(TableAtom(table), sympy.S.Zero, at)
            yield Switch(name, table_text(g), g, rate(g))


def labelled(
    among: tuple[Switch, ...], labels: Sequence[tuple[sympy.Basic, str]]
) -> tuple[Switch, ...]:
    """The switches, the conditions that have a label by it in place of their text.

    The opposite of a condition has the words for its begin and its end in the other order.
    """
    names = dict[sympy.Expr, str]()
    for condition, label in labels:
        parts = sorted(condition.atoms(Relational), key=str)
        for part in parts:
            text = label if len(parts) == 1 else f"{label} (part: {part})"
            g, (begin, end) = switching_function(part), label_sides(text)
            names[g], names[-g] = text, f"{end} / {begin}" if text == label else text
    return tuple(
        replace(s, text=names.get(s.g, s.text)) if s.kind == "condition" else s for s in among
    )


def find_switch(
    g: sympy.Expr, at_zero: Boundary, among: Sequence[Switch]
) -> tuple[int, bool] | None:
    """Number of the switch of a condition, and whether it is that of the opposite condition.

    Conditions on one surface share their switch where motions slide on it, since one share of both
    sides is Filippov's law for their sum, and else where they agree on what holds on it. A shared
    switch whose conditions do not agree is MIXED. Any other conditions of a scene have a switch.
    """
    for k, switch in enumerate(among):
        if not switch.alone and switch.g in (g, -g):
            opposite = switch.g != g
            agreed = at_zero.of_opposite() if opposite else at_zero
            indifferent = Boundary.INDIFFERENT in (agreed, switch.boundary)
            if switch.boundary is agreed or indifferent or kinds(g, Velocity):
                return k, opposite
    return None


def side_values(effects: Sequence[Named], among: tuple[Switch, ...]) -> tuple[SideValue, ...]:
    """The sides of the effects that hold, in their order."""
    numbers, sides = _alone(among), []
    for name, terms in effects:
        if isinstance(terms.hold, Rigid | OneWay):
            sides.append(SideValue(side(name), numbers[name], 0, 1))
        elif isinstance(terms.hold, Sticking):
            same = _same(terms.hold.slip, among)
            assert same is not None
            one = -1 if same[1] else 1
            sides.append(SideValue(side(name), same[0], one, -one))
    return tuple(sides)


def stiction(effects: Sequence[Named], among: tuple[Switch, ...]) -> tuple[tuple[str, int], ...]:
    """(effect, switch) of the frictions in joints whose stiction force a run determines.

    Their switch belongs to them alone: where a condition or another friction changes with the
    same slip, all of them follow Filippov's combination of the two modes.
    """
    switching = [s.switch for s in side_values(effects, among)]
    for _, terms in effects:
        functions = (switching_function(c) for c in _conditions(terms))
        switching += [same[0] for g in functions if (same := _same(g, among))]
    rubbing = {name for name, terms in effects if terms.friction and terms.friction.sticks}
    return tuple(
        (s.effect, k)
        for k, s in enumerate(among)
        if s.kind == "friction" and s.effect in rubbing and switching.count(k) == 1
    )


def prescribed_shares(
    effects: Sequence[Named], among: tuple[Switch, ...]
) -> tuple[tuple[str, int], ...]:
    """(effect, switch) of reactions and given frictions whose share α kernels take in mode 2.

    Beside a friction that follows from a reaction, and is no linear function of what keeps other
    functions at zero, superposition does not do. What switches with a condition has no force of
    both modes but their combination.
    """
    if not any(terms.friction for _, terms in effects):
        return ()
    functions = (switching_function(c) for _, e in effects for c in _conditions(e))
    own = {k for _, k in stiction(effects, among)}
    own |= {same[0] for g in functions if (same := _same(g, among))}
    return tuple(
        (s.effect, k) for k, s in enumerate(among) if s.kind != "condition" and k not in own
    )


def rigid_contacts(effects: Sequence[Named], among: tuple[Switch, ...]) -> tuple[RigidContact, ...]:
    """The rigid contacts, in the order of the effects."""
    numbers = _alone(among)
    return tuple(
        RigidContact(
            name, numbers[name], t in c.gap.free_symbols, rate(rate(c.gap)), c.restitution, c.scale
        )
        for name, c in ((name, terms.hold) for name, terms in effects)
        if isinstance(c, Rigid)
    )


def _alone(among: Sequence[Switch]) -> dict[str, int]:
    """Rigid contact or freewheel → number of its switch."""
    return {s.effect: k for k, s in enumerate(among) if s.alone}


def _same(g: sympy.Expr, among: Sequence[Switch]) -> tuple[int, bool] | None:
    """Number of the switch with g or -g that others may share, and whether it is -g."""
    for k, switch in enumerate(among):
        if not switch.alone and switch.g in (g, -g):
            return k, switch.g != g
    return None


def _conditions(terms: EffectTerms) -> tuple[Relational, ...]:
    """The conditions of an effect, or of what a run watches."""
    return conditions(terms.moving if terms.watched is None else [terms.watched])
