"""Effects → potential energy and forces; expressions known from another scene are reused.

Quantities of effects that a scene names as outputs: forces, lengths, rates, potentials.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import chain

import sympy
from sympy.core.relational import Relational

from codegen.declare import element as el
from codegen.declare.body import Bodies
from codegen.declare.returned_values import (
    forces_of,
    measures_of,
    optional_terms,
    potential_of,
    weights_of,
)
from codegen.declare.scene import Scene
from codegen.declare.state import WatchedCondition
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, derivative, kinds, rate, side
from codegen.derive.piecewise_conditions import kinks_as_pieces, tables_by_branches
from codegen.derive.power_continuation import continue_powers
from codegen.elements.forces.mass_flow import MassFlow
from codegen.elements.scalar_measures import along_scalar, unit_of

Measure = el.Measure


@dataclass(frozen=True)
class FrictionTerms:
    """A force -grip · N along a slip s, N from the reaction of a joint."""

    joint: str  # name of the joint that rubs
    slip: sympy.Expr  # ṡ; of a slip v of several components vᵀv / √(vᵀv + creep²)
    # strength · tanh(ṡ / creep), strength · σ of a friction that sticks, or strength · 1 along v
    grip: sympy.Expr
    direction: tuple[tuple[Coordinate, sympy.Expr], ...]  # (coordinate, ∂s/∂q), Q of a unit force
    contacts: tuple[el.Pressing, ...]  # loads as in `FrictionLaw`
    unit: str  # of the force
    sticks: bool = False  # whether the force is that of a mode, and not of the slip
    limit: sympy.Expr | None = None  # strength · μ_s/μ, factor of N at rest; None: does not stick


@dataclass(frozen=True)
class EffectTerms:
    """The terms of one effect."""

    potential: sympy.Expr | None  # V, J; None without one
    loads: tuple[tuple[Coordinate, sympy.Expr], ...]  # (coordinate, Q) of generalized forces
    # (s, f) of the forces that tend to make a scalar s(q, t) smaller, Q = -f s_q, with `SPEED` in f
    # for ṡ
    pulls: tuple[tuple[sympy.Expr, sympy.Expr], ...] = ()
    friction: FrictionTerms | None = None  # the force that follows from a joint's reaction
    hold: el.Hold | None = None  # how it keeps its switching function at zero
    reported: tuple[tuple[str, str, sympy.Expr], ...] = ()  # (component, unit, value) of its forces
    # the quantities of the effect that the scene names among its outputs
    measures: el.Measures = ()
    # (body, mass, acceleration) of the products that stand in V as one number
    weights: tuple[tuple[str, sympy.Expr, sympy.Expr], ...] = ()
    flux: sympy.Expr | None = None  # W, that matter brings beside the power of its force
    watched: sympy.Expr | None = None  # 1 where a condition holds that a run watches, else 0

    @property
    def moving(self) -> list[sympy.Expr]:
        """The scalars, forces and potential, in the order that their conditions are numbered in."""
        found = [*chain(*self.pulls), *(force for _, force in self.loads)]
        found += [] if self.flux is None else [self.flux]
        return found if self.potential is None else [*found, self.potential]

    @cached_property
    def gradient(self) -> tuple[tuple[Coordinate, sympy.Expr], ...]:
        """(coordinate, ∂V/∂q); for reading: the kernels take it from the values of V."""
        potential = self.potential
        moved = () if potential is None else kinds(potential, Coordinate)
        return tuple((q, derivative(potential, q)) for q in moved)

    @cached_property
    def forces(self) -> tuple[tuple[Coordinate, sympy.Expr], ...]:
        """(coordinate, Q) of all that has no potential; for reading."""
        total = dict(self.loads)
        for s, f in self.pulls:
            force = f.xreplace({SPEED: rate(s)})
            for q in kinds(s, Coordinate):
                total[q] = total.get(q, sympy.S.Zero) - force * derivative(s, q)
        rows = sorted(total.items(), key=lambda pair: pair[0].name)
        return tuple((q, force) for q, force in rows if force != 0)


def effect_terms(effect: el.Effect, bodies: Bodies) -> EffectTerms:
    """Potential and forces of `effect` in a scene with `bodies`."""
    potential = potential_of(effect, bodies)
    elastic: el.Pulls = ()
    if potential is not None:
        potential = _pieces(potential)
        if kinds(potential, Time):
            # What moves by itself, such as the far end of a spring, does work: no energy is stored.
            potential, elastic = None, ((potential, sympy.S.One),)
    forces = sorted(forces_of(effect, bodies).items(), key=lambda pair: pair[0].name)
    loads = tuple((q, f) for q, f in ((q, _pieces(force)) for q, force in forces) if f != 0)
    law, hold, along_scalars, reported = optional_terms(effect, bodies)
    along = ((s, f) for s, f in along_scalars if f != 0)
    pulls = tuple((tables_by_branches(s), _pull(s, f)) for s, f in along) + elastic
    components = tuple((part, unit, _pieces(value)) for part, unit, value in reported)
    friction = None if law is None else _friction(effect.name, law, hold)
    flux = _pieces(effect.energy_flux) if isinstance(effect, MassFlow) else None
    watched = _pieces(effect.indicator) if isinstance(effect, WatchedCondition) else None
    return EffectTerms(
        potential,
        loads,
        pulls,
        friction,
        hold,
        components,
        weights=weights_of(effect, bodies),
        flux=flux,
        watched=watched,
    )


@cache
def _pieces(expression: sympy.Expr) -> sympy.Expr:
    """A potential or a force with its kinks as pieces."""
    return tables_by_branches(continue_powers(kinks_as_pieces(expression)))


@cache
def _pull(s: sympy.Expr, f: sympy.Expr) -> sympy.Expr:
    """f with its kinks as pieces, and their conditions by coordinates and velocities."""
    pieces = continue_powers(kinks_as_pieces(f))
    turns = pieces.atoms(Relational)
    by_rates = {c: c.xreplace({SPEED: rate(s)}) for c in turns if c.has(SPEED)}
    return tables_by_branches(pieces.xreplace(by_rates))


def measured(measure: el.Measure) -> el.Measure:
    """A measure with its kinks as pieces, by the conditions of the forces."""
    if measure.along is None:
        return measure._replace(value=_pieces(measure.value))
    value = _pull(measure.along, measure.value)
    return measure._replace(value=value, along=tables_by_branches(measure.along))


def _friction(effect: str, law: el.FrictionLaw, law_at_rest: el.Hold | None) -> FrictionTerms:
    slip = law.slip
    direction = tuple((v.coordinate, derivative(slip, v)) for v in kinds(slip, Velocity))
    if len(law.slips) > 1 and law.creep is not None:  # against the growth of its size
        slip, direction_of_slip = slip - law.creep**2 / slip, sympy.S.One
    else:
        direction_of_slip = side(effect) if law.creep is None else sympy.tanh(slip / law.creep)
    grip, limit = law.strength * direction_of_slip, None
    if isinstance(law_at_rest, el.Sticking) and law.creep is None:
        more = 1 if law_at_rest.static is None else law_at_rest.static / law_at_rest.kinetic
        limit = law.strength * more
    return FrictionTerms(
        law.joint, slip, grip, direction, law.contacts, law.unit, law.creep is None, limit
    )


_WORD = {"N": "force", "N m": "torque"}  # unit → quantity


def effect_measures(effect: el.Effect, terms: EffectTerms, bodies: Bodies) -> el.Measures:
    """All quantities that an effect has as outputs, beside the components that it reports.

    What an effect does not say itself in ``measures(bodies)`` follows from its terms: of a force
    along one length or angle that, its rate and the force, of a friction in a joint the slip, of
    any other effect the generalized forces by coordinate; the potential of each that has one.
    """
    found = measures_of(effect, bodies)
    if found is None:
        found = _derived(effect, terms, bodies)
    names = {measure.row for measure in found} | {row for row, *_ in terms.reported}
    if terms.potential is not None and "potential" not in names:
        found = (*found, el.Measure("potential", "", "J", terms.potential))
    reported = {row for row, *_ in terms.reported}
    return tuple(measured(measure) for measure in found if measure.row not in reported)


def available_quantities(terms: EffectTerms, measures: el.Measures) -> set[str]:
    """Quantities of an effect that a scene may name, also those that it reports unasked."""
    units = {unit for _, unit, _ in terms.reported}
    named = {component for component, *_ in terms.reported if component in el.QUANTITIES}
    if terms.friction is not None:
        units |= {terms.friction.unit, "N"}
    return named | {m.quantity for m in measures} | {_WORD[unit] for unit in units & {*_WORD}}


def terms_in_scene(effect: el.Effect, scene: Scene, bodies: Bodies) -> EffectTerms | None:
    """The terms of an effect with the quantities that the scene asks for; None: it does not act.

    A kinematic scene has of an effect the geometry that it asks for, and nothing else.
    """
    outputs, kinematic = {*(scene.outputs or ())}, scene.analysis == "kinematics"
    asked = {q for q in el.QUANTITIES if outputs & {f"{q}s", f"{q}({effect.name})"}}
    if any(effect.name in one.owners for one in scene.expressions):
        asked = {*el.QUANTITIES}
    if effect.name in scene.states:  # the rate of a state, which no result calls a force
        asked = set()
    if kinematic and not asked - {*el.EXERTED}:
        return None
    terms = effect_terms(effect, bodies)
    if asked:
        asked -= {*el.EXERTED} if kinematic else {*()}
        measures = effect_measures(effect, terms, bodies)
        terms = replace(terms, measures=tuple(m for m in measures if m.quantity in asked))
    if kinematic:
        return EffectTerms(None, (), measures=terms.measures) if terms.measures else None
    return terms


def _derived(effect: el.Effect, terms: EffectTerms, bodies: Bodies) -> el.Measures:
    if terms.friction is not None:
        unit = "rad/s" if terms.friction.unit == "N m" else "m/s"
        return (el.Measure("rate", "", unit, terms.friction.slip),)
    pulls = optional_terms(effect, bodies).pulls
    if len(pulls) == 1 and not terms.loads and potential_of(effect, bodies) is None:
        ((s, force),) = pulls
        if unit := unit_of(s):
            return along_scalar(s, unit, force)
    forces = dict(terms.forces)
    for q, slope in terms.gradient:
        forces[q] = forces.get(q, sympy.S.Zero) - slope
    order = {q: k for k, q in enumerate(q for body in bodies for q in body.coordinates)}
    rows = sorted(forces, key=lambda q: (order.get(q, len(order)), q.name))
    return tuple(
        el.Measure(_WORD[unit], f"{q.owner}.{q.letter}", unit, forces[q])
        for q in rows
        for unit in (q.measure.force_unit,)
        if forces[q] != 0
    )
