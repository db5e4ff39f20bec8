"""The protocols of joints, drivers and forces, the same for the library's and a user's elements."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from inspect import Parameter, Signature
from itertools import chain
from typing import ClassVar, NamedTuple, Protocol, runtime_checkable

import sympy

from codegen.declare.body import Bodies, Body, Curve, Loads, Point, Pose
from codegen.declare.space_body import SpacePoint
from codegen.declare.space_frame import SpaceFrame
from codegen.declare.symbols import Coordinate, Velocity, coordinate, given, kinds, rate
from codegen.errors import ModelError
from codegen.readers.calls import declaring_class, readable_class
from codegen.readers.expressions import plain_expression
from codegen.readers.values import KindError, shown


@declaring_class("Frame")
@dataclass(frozen=True)
class Frame(Pose):
    """A body in the equations of an element: its coordinates before any model is known."""

    name: str

    @cached_property
    def r(self) -> sympy.ImmutableMatrix:
        """Position of the origin, 2 × 1."""
        return sympy.ImmutableMatrix([self.x, self.y])

    @cached_property
    def A(self) -> sympy.ImmutableMatrix:
        """Rotation matrix from the body's frame to the global one, 2 × 2 (Haug 2.4.4)."""
        c, s = sympy.cos(self.phi), sympy.sin(self.phi)
        return sympy.ImmutableMatrix([[c, -s], [s, c]])

    @cached_property
    def s(self) -> sympy.ImmutableMatrix:
        """Placeholder for a point s' of the body, 2 × 1."""
        return sympy.ImmutableMatrix([given(f"{self.name}_sx"), given(f"{self.name}_sy")])

    arm, point = SpaceFrame.arm, SpaceFrame.point

    def bind(self, point: Point) -> dict[sympy.Symbol, sympy.Expr]:
        """Placeholders of this frame → their values for a point of a body in a model."""
        place: object = point
        if not isinstance(place, Point):
            raise ModelError(
                f"frame.bind({shown(point)}): give a point of a body, as body.at(0, 0)."
            )
        if isinstance(place, SpacePoint):
            raise ModelError(f"frame.bind({shown(point)}): bind a point in space in a SpaceFrame.")
        body, sx, sy = point.body, given(f"{self.name}_sx"), given(f"{self.name}_sy")
        bindings = {self.x: body.position[0], self.y: body.position[1]}
        if body.angle is None:  # a statement that asks for the angle itself is refused
            ends = sympy.cos(self.phi), sympy.sin(self.phi)
            bindings |= dict(zip(ends, body.rotation, strict=True))
        else:
            bindings[self.phi] = body.angle
        return bindings | dict(zip((sx, sy), point.place, strict=True))


I, J = Frame("i"), Frame("j")  # noqa: E741 (Haug's names for the two bodies of a joint)
FRAMES = (Frame, SpaceFrame)


@declaring_class("JointReaction")
@dataclass(frozen=True)
class JointReaction:
    """The multipliers of a joint as a force and a torque that the first body exerts on the second.

    Attributes
    ----------
    direction
        The joint's x axis in the global frame, 2 × 1, of unit length, in placeholders.
    on
        The frame, `I` or `J`, of the body on which the reaction acts.
    sign
        +1 to report the reaction on that body, -1 for its opposite.
    arm
        The global vector from the body's centre to the place of the reaction, 2 × 1, in
        placeholders; None: the joint's point of this body.
    """

    direction: sympy.Matrix
    on: Frame = J
    sign: int = 1
    arm: sympy.Matrix | None = None


@declaring_class("WrenchReaction")
@dataclass(frozen=True)
class WrenchReaction:
    """The multipliers of a joint in space as a force and a torque, six numbers in global axes.

    The first body of the joint exerts them on the second at the joint's point.

    Attributes
    ----------
    on
        The frame of the second body.
    arm
        The global vector from the body's centre to that point, 3 × 1, in placeholders; None: the
        point that is bound in the frame.
    rows
        The number of rows that hold the bodies, the first ones; None: all. The forces along own
        coordinates belong to those who exert them.
    tension
        Of a rod: the factor of the first multiplier in the force with which it pulls its ends
        together, the component ``"axial"``; None: there is none.
    """

    on: SpaceFrame
    arm: sympy.Matrix | None = None
    rows: int | None = None
    tension: sympy.Expr | None = None


@declaring_class("ConjugateReaction")
@dataclass(frozen=True)
class ConjugateReaction:
    """Each multiplier as the generalized force -λ along the expression that its row constrains."""

    components: tuple[tuple[str, str], ...]
    """(name, unit), one a row."""

    @classmethod
    def along(cls, letter: str) -> "ConjugateReaction":
        """The force or torque along a coordinate of that letter."""
        kind = coordinate("", letter).measure
        name = f"f{letter}" if kind.unit == "m" else "torque" if kind.unit == "rad" else "force"
        name = "force" if letter == "slide" else name
        return cls(((name, kind.force_unit),))


@declaring_class("Statement")
@dataclass(frozen=True)
class Statement:
    """One symbolic statement Φ(q, t) = 0, from which everything else about a constraint follows.

    Attributes
    ----------
    phi
        The equations, written with placeholders or with coordinates of a model.
    rows
        A word for each equation (``"x"``, ``"angle"`` …).
    bindings
        Placeholder → number, parameter or expression of the model (made symbolic here); for a body
        without an angle, the cosine and sine of the placeholder.
    reaction
        How the multipliers are reported as forces; None: not at all.
    own
        (row, coordinate) of each own coordinate of the element, such as the parameter of a cam's
        profile at the contact. The coordinate has no mass, and the row determines it: once the rows
        before it are solved, ∂(row)/∂(coordinate) vanishes nowhere on the constraints.
    facing
        Letters of vectors that bodies i and j share; the equations hold for opposite ones, too.
    """

    phi: tuple[sympy.Expr, ...]
    rows: tuple[str, ...]
    reaction: JointReaction | WrenchReaction | ConjugateReaction | None
    bindings: dict[sympy.Symbol, sympy.Expr] = field(default_factory=dict)
    own: tuple[tuple[str, Coordinate], ...] = ()
    facing: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        given_bindings: object = self.bindings
        if not isinstance(given_bindings, Mapping):
            raise ModelError(
                f"Statement: bindings is {shown(self.bindings)}; give a dictionary, placeholder: "
                "value."
            )
        bindings = {}
        for place, value in self.bindings.items():
            try:
                bindings[plain_expression(place)] = plain_expression(value)
            except KindError:
                raise ModelError(
                    f"Statement: the placeholder {shown(place)} is bound to {shown(value)}; bind "
                    "placeholders to numbers or expressions."
                ) from None
        object.__setattr__(self, "bindings", bindings)


Pressing = tuple[tuple[tuple[str, sympy.Expr], ...], ...]
"""A contact's load, a vector: each entry a sum of (component of the reaction, factor)."""


@declaring_class("FrictionLaw")
@dataclass(frozen=True)
class FrictionLaw:
    """A force that follows from a joint's reaction, f = -strength · N · tanh(ṡ / creep).

    Without creep it is f = -strength · N · σ, with σ the side of the effect's `Sticking`. With a
    slip of several components it is f = -strength · N · ṡ / √(ṡᵀṡ + creep²) along them.
    """

    joint: str  # name of the joint that rubs
    strength: sympy.Expr  # μ, or μ times an arm in m
    creep: sympy.Expr | None  # speed below which the joint creeps; None where it sticks
    # the slip s(q), m or rad, or ṡ, linear in velocities; the force's direction; or several of them
    along: sympy.Expr | tuple[sympy.Expr, ...]
    contacts: tuple[Pressing, ...]  # the loads whose sizes add up to N
    unit: str  # of f

    @property
    def slips(self) -> tuple[sympy.Expr, ...]:
        """The components of `along`."""
        return self.along if isinstance(self.along, tuple) else (self.along,)

    @property
    def slip(self) -> sympy.Expr:
        """ṡ; of several components √(ṡᵀṡ + creep²), along whose slopes by velocities f acts."""
        speeds = [s if kinds(s, Velocity) else rate(s) for s in self.slips]
        if len(speeds) > 1 and self.creep is None:
            raise ModelError("friction() has a slip of several components; give it creep=.")
        parts = (*speeds, self.creep)
        return speeds[0] if len(speeds) == 1 else sympy.sqrt(sympy.Add(*(s**2 for s in parts)))


@declaring_class("Sticking")
@dataclass(frozen=True)
class Sticking:
    """A friction that may hold: its force changes its sign with the slip.

    The effect writes its force with the symbol ``side(name)``, σ = 1 where ṡ > 0 and σ = -1 where
    not. At ṡ = 0 it exerts whatever keeps ṡ there, up to μ_s/μ times its force in sliding.
    """

    slip: sympy.Expr  # ṡ(t, q, q̇), m/s or rad/s
    kinetic: sympy.Expr  # μ, of numbers and parameters, as is μ_s
    static: sympy.Expr | None = None  # μ_s; None: μ


@declaring_class("Rigid")
@dataclass(frozen=True)
class Rigid:
    """A contact that yields nothing: g ≥ 0, and a reaction only at g = 0 (Signorini).

    The effect writes its force with the symbol ``side(name)``, σ = 0 where g > 0 and σ = 1 where
    not, as that of the reaction `scale`; a run determines the multiple that keeps the gap closed.
    """

    gap: sympy.Expr  # g(t, q), m
    restitution: sympy.Expr  # e = -ġ⁺/ġ⁻ of an impact, from 0 to 1, of numbers and parameters
    scale: sympy.Expr  # F0, N, positive, of numbers and parameters


@declaring_class("OneWay")
@dataclass(frozen=True)
class OneWay:
    """A speed that cannot become negative: w ≥ 0, T ≥ 0, T w = 0.

    The effect writes its force with the symbol ``side(name)``, σ = 0 where w > 0 and σ = 1 where
    not, as that of the reaction `scale`; a run determines the multiple that keeps w at zero. A
    speed that something else makes negative ends in an impact, w⁺ = 0.
    """

    slip: sympy.Expr  # w(t, q, q̇), m/s or rad/s
    scale: sympy.Expr  # T0, N or N m, positive, of numbers and parameters


Hold = Sticking | Rigid | OneWay


class Element(Protocol):
    """The common part of joints, drivers and effects.

    A class may derive from `Constraint` or `Effect`, and then inherits the methods that stand
    here, or have the same methods without deriving from them. One that asks something of its
    numbers, also as parameters, has, besides, ``conditions() -> (Condition, ...)``; a joint with
    closed curves ``profiles() -> ((curve, whether it must be convex), ...)``; one that estimates
    its own coordinates ``near(numbers) -> {coordinate: value}``, from values of the bodies'
    coordinates and of the parameters; one that stands for a body has it as ``instead_of``; one
    that is drawn otherwise than by a mark at each of its points has ``shapes() -> (Shape, ...)``.
    """

    kind: ClassVar[str]
    """A few words, the same for all elements of the class."""
    name: str
    """The modeller's name, an identifier."""

    def __init__(self, *fields: object, **named: object) -> None:
        """Refuse an element without equations; `element` gives a class of one's own its fields."""
        if type(self) in (Element, Constraint, Effect):
            base = type(self).__name__
            raise ModelError(
                f"{base} is a base class and has no equations; derive a class from it, with the "
                f"decorator @element: class Drag({base})."
            )
        super().__init__(*fields, **named)

    vars()["__init__"].__signature__ = Signature(
        [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
    )

    @property
    def bodies(self) -> Bodies:
        """The bodies on which the element acts; empty: all of the scene (gravity).

        They are the bodies of its fields: points, curves, bodies or tuples of them, in their order.
        """
        values = (v if isinstance(v, tuple) else (v,) for v in vars(self).values())
        places = (v for v in chain.from_iterable(values) if isinstance(v, Body | Point | Curve))
        return tuple(v if isinstance(v, Body) else v.body for v in places)

    def problems(self) -> list[str]:
        """Problems of the element alone, one sentence each, which `label` begins."""
        return []


@runtime_checkable
class Constraint(Element, Protocol):
    """A joint or driver: brings equations Φ(q, t) = 0."""

    def statement(self) -> Statement:
        """The equations."""


@runtime_checkable
class Effect(Element, Protocol):
    """A force: brings a potential V or generalized forces Q.

    Some kinds have more methods: ``friction() -> FrictionLaw`` for a force from a joint's reaction;
    ``hold(bodies) -> Sticking | Rigid | OneWay | None`` for friction that sticks, rigid contacts
    and freewheels; ``pulls(bodies) -> ((s, f), ...)`` for forces along scalars; ``reported(bodies)
    -> ((component, unit, value), ...)`` for a reported force; ``measures(bodies) -> (Measure,
    ...)`` for outputs that do not follow from the others; ``exerting(value) -> Effect`` for one
    force or torque, which then has that value. `bodies` are those of the scene.
    """

    def potential(self, bodies: Bodies) -> sympy.Expr | None:
        """V in joule, if the effect has a potential."""
        return None

    def forces(self, bodies: Bodies) -> Loads:
        """Generalized forces Q that have no potential, without those of `pulls`."""
        return {}


Pulls = tuple[tuple[sympy.Expr, sympy.Expr], ...]
"""(s, f) of forces that tend to make a scalar s(q, t) smaller, Q = -f s_q.

The virtual work is -f δs; with s a length this is Haug's Q of a tension (6.1). f may contain
`SPEED`, the rate of s.
"""
Reported = tuple[tuple[str, str, sympy.Expr], ...]
"""(component, unit, value) of the forces that an effect reports."""


QUANTITIES = (
    "force", "torque", "length", "angle", "rate", "deflection", "gap", "penetration", "potential",
)  # fmt: skip
"""Quantities of an effect that a scene may name as outputs, ``force(strut)``."""
EXERTED = ("force", "torque", "potential")
"""Those of them that a scene has in which effects act; the others are geometry."""


@readable_class
class Measure(NamedTuple):
    """A quantity of an effect that is computed where a scene names it among its outputs."""

    quantity: str  # one of `QUANTITIES`
    component: str  # such as "fx"; empty where the quantity has no components
    unit: str
    value: sympy.Expr  # with `SPEED` for the rate of `along`
    along: sympy.Expr | None = None  # a scalar s(q, t)

    @property
    def row(self) -> str:
        """Its name among the components of its effect."""
        if not self.component or (self.quantity, self.unit) in (("force", "N"), ("torque", "N m")):
            return self.component or self.quantity  # its unit says what it is
        return f"{self.quantity}.{self.component}"


Measures = tuple[Measure, ...]


class OptionalTerms(NamedTuple):
    """The terms that not every effect has."""

    friction: FrictionLaw | None
    hold: Hold | None
    pulls: Pulls
    reported: Reported


def label(element: object) -> str:
    """``revolute 'A'``: the element in messages."""
    kind = getattr(element, "kind", "body")
    name = getattr(element, "name", "")
    return f"{kind} '{name}'" if isinstance(name, str) and name else str(kind)
