"""Quantities of effects that a scene names as outputs: forces, lengths, rates, potentials."""

from dataclasses import replace

import sympy

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.returned_terms import measures_of, optional_terms, potential_of
from codegen.declare.scene import Scene
from codegen.declare.symbols import SPEED
from codegen.derive.effect_terms import EffectTerms, effect_terms, measured
from codegen.elements.forces.scalar_measures import is_angle, is_length

_WORD = {"N": "force", "N m": "torque"}  # unit → quantity


def effect_measures(
    effect: el.Effect, terms: EffectTerms, bodies: tuple[Body, ...]
) -> tuple[el.Measure, ...]:
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


def available_quantities(terms: EffectTerms, measures: tuple[el.Measure, ...]) -> set[str]:
    """Quantities of an effect that a scene may name, also those that it reports unasked."""
    units = {unit for _, unit, _ in terms.reported}
    named = {component for component, *_ in terms.reported if component in el.QUANTITIES}
    if terms.friction is not None:
        units |= {terms.friction.unit, "N"}
    return named | {m.quantity for m in measures} | {_WORD[unit] for unit in units & {*_WORD}}


def terms_in_scene(effect: el.Effect, scene: Scene, bodies: tuple[Body, ...]) -> EffectTerms | None:
    """The terms of an effect with the quantities that the scene asks for; None: it does not act.

    A kinematic scene has of an effect the geometry that it asks for, and nothing else.
    """
    outputs, kinematic = {*(scene.outputs or ())}, scene.analysis == "kinematics"
    asked = {q for q in el.QUANTITIES if outputs & {f"{q}s", f"{q}({effect.name})"}}
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


def _derived(
    effect: el.Effect, terms: EffectTerms, bodies: tuple[Body, ...]
) -> tuple[el.Measure, ...]:
    if terms.friction is not None:
        unit = "rad/s" if terms.friction.unit == "N m" else "m/s"
        return (el.Measure("rate", "", unit, terms.friction.slip),)
    pulls = optional_terms(effect, bodies).pulls
    if len(pulls) == 1 and not terms.loads and potential_of(effect, bodies) is None:
        ((s, force),) = pulls
        turns = is_angle(s)
        if turns or is_length(s):
            word, unit = ("angle", "rad") if turns else ("length", "m")
            exerted, force_unit = ("torque", "N m") if turns else ("force", "N")
            return (
                el.Measure(word, "", unit, s),
                el.Measure("rate", "", f"{unit}/s", SPEED, s),
                el.Measure(exerted, "", force_unit, force, s),
            )
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
