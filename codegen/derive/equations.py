"""A model and one of its scenes → all equations, element by element, as immutable values."""

from collections.abc import Iterator, Set
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import sympy

from codegen.declare.body import Bodies, Body
from codegen.declare.element import Constraint, Effect, Element, Statement, label
from codegen.declare.returned_values import own_coordinates, replaced_body
from codegen.declare.scene import ExpressionOutput, Scene
from codegen.declare.space_body import SpaceBody
from codegen.declare.space_frame import I, J
from codegen.declare.state import WATCHED, State, WatchedCondition, states_in
from codegen.declare.symbols import Coordinate, Parameter, ParameterDeclaration, Velocity, dotted
from codegen.derive import constraint_terms as cs
from codegen.derive import switching_functions as sf
from codegen.derive.derived_outputs import derived_outputs
from codegen.derive.effect_terms import EffectTerms, effect_terms, terms_in_scene
from codegen.derive.inertia import inertia
from codegen.derive.parameter_conditions import (
    ElementCondition,
    Profile,
    are_judged_in_runs,
    carried,
    element_conditions,
    expressions_in,
    outline_conditions,
    profiles_of,
)
from codegen.derive.scene_picture import NO_PICTURE, ScenePicture, scene_picture
from codegen.elements.forces.mass_flow import MassLaw
from codegen.garbage_collection import collection_paused
from codegen.model.base import TRACKED
from codegen.readers.calls import errors_at

if TYPE_CHECKING:
    from codegen.model import Model


@dataclass(frozen=True)
class ConstraintEquations:
    """The equations of one joint or driver in a scene."""

    name: str
    kind: str
    driver: bool
    statement: Statement
    terms: cs.ConstraintTerms

    @property
    def facing(self) -> Iterator[tuple[Any, ...]]:
        """(e0 of body i, its vector, e0 of body j, its vector) of the vectors that they share."""
        bound = self.statement.bindings
        for letter in self.statement.facing:
            ends = ((bound[at.p[0]], (bound[x] for x in at.given(letter))) for at in (I, J))
            yield tuple(one for e0, of in ends for one in (e0, tuple(map(float, of))))


@dataclass(frozen=True)
class EffectEquations:
    """The equations of one effect in a scene."""

    name: str
    kind: str
    terms: EffectTerms
    on_ground: bool = False  # whether it may exert a force on the ground


class SampledValue(NamedTuple):
    """A value that a clock renews, by its symbol."""

    name: str
    symbol: Velocity
    sample: sympy.Expr | None  # None: a run brings it
    every: sympy.Expr  # s
    delay: sympy.Expr  # s
    watched: int = -1  # number of the condition that renews it, in place of a clock


class TurningBody(NamedTuple):
    """A body in space that takes part."""

    name: str
    p: tuple[Coordinate, ...]  # its Euler parameters
    mass: sympy.Expr | None
    inertia: sympy.ImmutableMatrix | None  # J', 3 × 3; None where no masses move
    pose: tuple[float, ...]  # at the drawing, of its seven coordinates


MassEntry = tuple[int, int, sympy.Expr]  # (row, column, entry) of M
TOUCHING = ("contact", "rigid contact", "stop", "dry friction")  # perhaps the ground, unnamed
OWN = "body"  # kind of the constraints that a body brings itself


@dataclass(frozen=True)
class Equations:
    """The equations of a scene; nothing downstream reads the declaration."""

    model: str
    scene: Scene
    bodies: tuple[str, ...]
    coordinates: tuple[Coordinate, ...]
    parameters: tuple[ParameterDeclaration, ...]  # those that something which takes part depends on
    # (row, column, entry) of M, sorted: the whole diagonal, zero for the coordinates that elements
    # bring, and what else is not zero. Empty in kinematic scenes.
    mass: tuple[MassEntry, ...]
    # (column, Q_v), quadratic in velocities, where M depends on q
    inertia_force: tuple[tuple[int, sympy.Expr], ...]
    constraints: tuple[ConstraintEquations, ...]
    left_out: tuple[tuple[str, str], ...]
    unused: tuple[str, ...]  # names of the other parameters
    effects: tuple[EffectEquations, ...] = ()
    switches: tuple[sf.Switch, ...] = ()
    sides: tuple[sf.SideValue, ...] = ()  # values, by mode, of the symbols of frictions, contacts
    stiction: tuple[tuple[str, int], ...] = ()  # (effect, switch): a run determines the force
    shares: tuple[tuple[str, int], ...] = ()  # the same of contacts and others, the share α
    contacts: tuple[sf.RigidContact, ...] = ()
    conditions: tuple[ElementCondition, ...] = ()  # on parameters, in terms of `parameters` alone
    profiles: tuple[Profile, ...] = ()
    states: tuple[State, ...] = ()
    watched: tuple[WatchedCondition, ...] = ()
    # (joints, scene) of several joints that may come or go at one instant
    together: tuple[tuple[tuple[str, ...], str], ...] = ()
    labels: tuple[tuple[sympy.Basic, str], ...] = ()  # of conditions, what events are called
    picture: ScenePicture = NO_PICTURE
    turning: tuple[TurningBody, ...] = ()
    derived: tuple[ExpressionOutput, ...] = ()

    @property
    def shakes(self) -> bool:
        """Whether the force on the ground is an output."""
        needed = (one.owners for one in self.scene.expressions)
        return "shaking" in (self.scene.outputs or ()) or any("ground" in of for of in needed)

    @property
    def sampled(self) -> tuple[SampledValue, ...]:
        """The states that a clock renews."""
        one, zero = sympy.S.One, sympy.S.Zero
        values, numbers = list[SampledValue](), dict[str, list[int]]()
        for k, condition in enumerate(self.watched):
            numbers.setdefault(condition.target, []).append(k)
        for s in self.states:
            if s.clock:
                clock = s.clock
                values.append(SampledValue(s.name, s.symbol, s.sample, clock.every, clock.delay))
            for k, trigger in zip(numbers.get(s.name, ()), s.triggers, strict=True):
                values.append(SampledValue(s.name, s.symbol, trigger.sample, one, zero, k))
        return tuple(values)

    def without_effect(self, name: str) -> "Equations":
        """These equations without an effect, and without the states that it alone contains."""
        rest = tuple(e for e in self.effects if e.name != name)
        named = {state.name for state in self.states} & {*self.scene.request.effects}
        rates = {state.name for state in self.states}
        effects = [e.terms for e in rest if e.name not in rates]
        phi = (row for c in self.constraints for row in c.statement.phi)
        needed = {*named, *states_in(*expressions_in(effects), *phi)}
        pending = {*needed}
        while pending:
            parts = [e for state in self.states if state.name in pending for e in state.expressions]
            pending = {*states_in(*parts)} - needed
            needed |= pending
        kept = tuple(e for e in rest if e.name not in rates - needed)
        return self._with_states(needed).with_effects(kept)

    def _with_states(self, names: Set[str]) -> "Equations":
        """These equations with the states of these names alone, effects as they are."""
        gone = {s.integral for s in self.states if s.name not in names}
        left = [k for k, q in enumerate(self.coordinates) if q not in gone]
        place = {k: new for new, k in enumerate(left)}
        return replace(
            self,
            states=tuple(s for s in self.states if s.name in names),
            coordinates=tuple(self.coordinates[k] for k in left),
            mass=tuple((place[i], place[k], m) for i, k, m in self.mass if {i, k} <= {*place}),
            inertia_force=tuple((place[k], f) for k, f in self.inertia_force),
        )

    def with_effects(self, effects: tuple[EffectEquations, ...]) -> "Equations":
        """These equations with other effects, their switching functions, conditions and outputs."""
        gone = {label(e) for e in self.effects} - {label(e) for e in effects}
        lost = {e.name for e in self.effects} - {e.name for e in effects}
        named = tuple((e.name, e.terms) for e in effects)
        switches, moves = (
            sf.labelled(sf.switches(named), self.labels),
            self.scene.analysis == "dynamics",
        )
        joints = ((c.name, c.statement.phi, c.statement.bindings) for c in self.constraints)
        forces = ((name, terms.moving, dict[sympy.Symbol, sympy.Expr]()) for name, terms in named)
        switches += tuple(sf.profile_knots((*joints, *forces))) if moves else ()
        return replace(
            self,
            effects=effects,
            derived=tuple(one for one in self.derived if lost.isdisjoint(one.owners)),
            switches=switches,
            sides=sf.side_values(named, switches),
            stiction=sf.stiction(named, switches) if moves else (),
            shares=sf.prescribed_shares(named, switches) if moves else (),
            contacts=sf.rigid_contacts(named, switches),
            conditions=tuple(c for c in self.conditions if c.element not in gone),
        )


def tracked_points(equations: Equations) -> tuple[str, ...]:
    """Names of the tracked points that take part, those whose paths are outputs."""
    return tuple(e.name for e in equations.effects if e.kind == TRACKED)


@dataclass(frozen=True)
class Parts:
    """What takes part in a scene, by name; joints whose bodies all do, unless the scene opens them.

    A link that stands for a body takes part where this body does not.
    """

    bodies: Bodies
    states: tuple[State, ...]
    joints: dict[str, Constraint]
    drivers: dict[str, Constraint]
    effects: dict[str, Effect]
    moves: bool  # whether forces act

    @property
    def acting(self) -> list[Element]:
        """The joints, drivers and, but in kinematics, effects."""
        effects = self.effects if self.moves else {}
        return [*self.joints.values(), *self.drivers.values(), *effects.values()]


def parts_of(model: "Model", scene: Scene) -> Parts:
    """What takes part in a scene of a model."""
    present = {"ground", *scene.bodies}
    joints = {
        name: _counting(joint, scene.counted) if scene.counted else joint
        for name, joint in model.joints.items()
        if name not in scene.inactive_joints
        and all(body.name in present for body in joint.bodies)
        and ((body := replaced_body(joint)) is None or body.name not in present)
    }
    return Parts(
        tuple(model.bodies[name] for name in scene.bodies),
        tuple(model.states[name] for name in scene.states),
        joints,
        {name: model.drivers[name] for name in scene.drivers},
        model.acting(scene),
        scene.analysis != "kinematics",
    )


def _counting(joint: Constraint, counted: tuple[str, ...]) -> Constraint:
    """The joint with those of its coordinates that are counted."""
    letters = tuple(q.letter for q in own_coordinates(joint) if dotted(q) in counted)
    return cast(Any, joint).counting(letters) if letters else joint


def body_equations(body: Body) -> ConstraintEquations:
    """The equations between the coordinates of a body, whose reactions are not reported."""
    words, phi = zip(*body.equations, strict=True)
    statement = Statement(phi, words, None)
    return ConstraintEquations(body.name, OWN, False, statement, cs.statement_terms(statement))


def _constraint_equations(element: Constraint, driver: bool) -> ConstraintEquations:
    with errors_at(label(element)):
        terms = cs.constraint_terms(element)
        return ConstraintEquations(element.name, element.kind, driver, *terms)


def _effect_equations(scene: Scene, parts: Parts) -> Iterator[EffectEquations]:
    """The equations of the effects that act in a scene, or whose geometry it asks for."""
    for name, effect in parts.effects.items():
        with errors_at(label(effect)):
            terms: EffectTerms | None
            if effect.kind == TRACKED:
                terms = effect_terms(effect, parts.bodies)
            else:
                terms = terms_in_scene(effect, scene, parts.bodies)
            if terms is not None:
                grounded = effect.kind in TOUCHING or any(body.fixed for body in effect.bodies)
                yield EffectEquations(name, effect.kind, terms, grounded)


@collection_paused()
def derive(model: "Model", scene: Scene) -> Equations:
    """Instantiate every element that takes part in `scene`."""
    parts = parts_of(model, scene)
    bodies, states, joints, drivers = parts.bodies, parts.states, parts.joints, parts.drivers
    constraints = tuple(body_equations(body) for body in bodies if body.equations)
    constraints += tuple(
        _constraint_equations(e, e.name in drivers) for e in (*joints.values(), *drivers.values())
    )
    coordinates = (
        *(q for body in bodies for q in body.coordinates),
        *(state.integral for state in states),
        *(q for c in constraints for _, q in c.statement.own),
    )
    watched = model.watched(scene)
    if scene.analysis == "dynamics":
        watched += tuple(law.exhaustion for law in joints.values() if isinstance(law, MassLaw))
    effects = tuple(_effect_equations(scene, parts))
    effects += tuple(
        EffectEquations(one.name, one.kind, effect_terms(one, bodies)) for one in watched
    )
    mass, force = inertia(bodies, states, coordinates) if parts.moves else ((), ())
    # the parameters of the elements that take part
    bound = [(c.terms, [*c.statement.bindings.values()]) for c in constraints]
    rates = [s.expressions for s in states]
    points = (e for e in parts.effects.values() if e.kind == TRACKED)
    joined = ((c.name, c.statement) for c in constraints)
    derived = tuple(derived_outputs(scene, joined, points))
    used = {
        symbol.name
        for expression in expressions_in((mass, force, rates, effects, bound, derived))
        for symbol in expression.free_symbols
        if isinstance(symbol, Parameter)
    }
    values = {p.name: p.value for p in model.parameters.values()} | dict(scene.parameters)
    parameters = tuple(
        replace(p, value=values[p.name]) for p in model.parameters.values() if p.name in used
    ) + tuple(ParameterDeclaration(name, 1.0, "", "positive") for name in scene.unknown)
    acting = {e.name for e in effects if e.kind != WATCHED}
    everything = ((model.joints, joints), (model.drivers, drivers), (model.effects, acting))
    drawn: dict[str, list[Element]] = {
        "joint": [*joints.values()],
        "driver": [*drivers.values()],
        "force": [e for e in parts.effects.values() if parts.moves or e.kind == TRACKED],
    }
    drawn["force"] += (  # points are drawn, outputs or not
        e for e in model.effects.values()
        if e.kind == TRACKED and e.name not in parts.effects and {*e.bodies} <= {*bodies}
    )  # fmt: skip
    equations = Equations(
        model=model.name,
        scene=scene,
        bodies=scene.bodies,
        coordinates=coordinates,
        parameters=parameters,
        mass=mass,
        inertia_force=force,
        constraints=constraints,
        left_out=tuple(
            (e.name, e.kind) for of, own in everything for e in of.values() if e.name not in own
        ),
        unused=tuple(name for name in model.parameters if name not in used),
        states=states,
        watched=watched,
        together=model.together(scene),
        labels=tuple(model.labels.items()),
        picture=scene_picture(model.ground, bodies, drawn, values, frozenset(used)),
        turning=tuple(
            TurningBody(b.name, b.p, b.mass, b.inertia, (*b.place, *b.attitude))
            for b in bodies
            if isinstance(b, SpaceBody)
        ),
        derived=derived,
    )
    conditions, profiles = outline_conditions(bodies), list[Profile]()
    defaults = {Parameter(name, real=True): value for name, value in values.items()}
    varies = bool(parameters) and not scene.frozen
    for element in parts.acting:
        with errors_at(label(element)):
            conditions += element_conditions(element, bodies) if varies else ()
            found = profiles_of(element, scene, parts.drivers.values(), defaults)
            profiles += found if are_judged_in_runs(found, defaults, varies) else ()
    once = carried(conditions, parameters, model.defaults) if varies else ()
    equations = replace(equations, conditions=once, profiles=tuple(profiles))
    return equations.with_effects(effects)
