"""The effects of a declaration: everything that pushes, pulls or turns."""

from collections.abc import Callable, Mapping
from typing import Any, Literal

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect
from codegen.declare.symbols import MASSES, Coordinate, Velocity, dotted
from codegen.elements.forces.applied import (
    AppliedForce,
    AppliedTorque,
    GeneralizedForce,
    Gravity,
    LineForce,
    Potential,
)
from codegen.elements.forces.mass_flow import MassFlow
from codegen.elements.forces.springs import Bushing, Spring, TorsionSpring
from codegen.elements.forces.transmissions import ElasticBelt, GearWithBacklash, Motor, OneWayClutch
from codegen.model.base import Declarations, Place, declares
from codegen.readers.values import shown

Characteristic = Callable[[sympy.Expr, sympy.Expr], Any]  # (ℓ, ℓ̇) or (θ, θ̇) → force or torque


class Forces(Declarations):
    """Forces, springs, motors and potentials of a declaration."""

    @declares(Gravity)
    def gravity(self, name: str, g: tuple[Any, Any]) -> Effect:
        """Uniform gravity (g_x, g_y), m/s², on every body of the scene."""

    @declares(AppliedForce, point="on")
    def force(
        self, name: str, on: Place, fx: Any = 0, fy: Any = 0, when: Any = None,
        frame: Literal["ground", "body"] = "ground", from_: Body | None = None, label: str = "",
    ) -> Effect:  # fmt: skip
        """A force (fx, fy) in N at a point, while the condition `when` holds.

        Parameters
        ----------
        on
            The point at which it acts; a body means its centre of mass.
        fx, fy
            In N, any expressions of t, q, q̇ and parameters.
        when
            The force acts while this condition holds; None: always.
        frame
            ``"ground"`` for global axes, ``"body"`` for those of the body of `on`.
        from_
            The body that exerts the force, on which (-fx, -fy) acts at the same place; None: none.
        label
            The name of the events of `when`, such as ``"valve opens / valve closes"``: one for the
            instant at which `when` begins to hold, and one for its end.
        """

    @declares(MassFlow, point="on")
    def mass_flow(
        self, name: str, on: Place, *, velocity: tuple[Any, Any] | None = None,
        relative: tuple[Any, Any] | None = None, share: Any = 1,
    ) -> Effect:  # fmt: skip
        """Matter that comes to a body of varying mass, or leaves it, in each scene with the body.

        Parameters
        ----------
        on
            The point of the body where the matter comes or goes; a body means its centre of mass.
        velocity
            The velocity of the matter before it comes, or after it left, m/s, in global axes.
        relative
            In its place the velocity relative to the point of the body, in the axes of the body.
        share
            The part of the rate of the body's mass that flows here; those of a body add up to 1.
        """

    @declares(AppliedTorque, body="on")
    def torque(
        self, name: str, on: Body, value: Any, when: Any = None, from_: Body | None = None,
        label: str = "",
    ) -> Effect:  # fmt: skip
        """A torque in N m on a body, while the condition `when` holds.

        Parameters
        ----------
        on
            The body that it turns.
        value
            In N m, counter-clockwise positive, any expression of t, q, q̇ and parameters.
        when
            The torque acts while this condition holds; None: always.
        from_
            The body that exerts the torque; the opposite acts on it. None: the torque comes from
            outside, and no body gets the opposite.
        label
            The name of the events of `when`.
        """

    @declares(LineForce)
    def line_force(
        self, name: str, i: Place, j: Place, value: Any, when: Any = None, label: str = ""
    ) -> Effect:
        """A force along the line of two points: a cylinder, a cable, a magnet.

        Parameters
        ----------
        i, j
            Points of two bodies; a body means its centre of mass.
        value
            In N, positive where it pulls the points together: an expression of t, q, q̇, tables and
            parameters, or a function of the length ℓ, m, and its rate ℓ̇, m/s, that returns one.
        when
            The force acts while this condition holds; None: always.
        label
            The name of the events of `when`.
        """

    def label(self, condition: Any, words: str) -> Any:
        """Name the events of a condition, wherever the condition stands; returns the condition.

        Parameters
        ----------
        condition
            A comparison in a piecewise force, a `when=` or another law, or the opposite comparison.
        words
            The event when the condition begins to hold and, after ``" / "``, when it ceases to,
            such as ``"exhaust valve opens / exhaust valve closes"``.
        """
        self._read.condition(condition, f"label {shown(words)}", words or " ")
        return condition

    @declares(Potential)
    def potential(self, name: str, energy: Any) -> Effect:
        """A potential energy V(q) in J, as a plain expression."""

    def generalized_force(
        self, name: str, components: Mapping[Any, Any], when: Any = None
    ) -> Effect:
        """Generalized forces Q: coordinate → plain expression (N for lengths, N m for angles)."""
        pairs = []
        like = "{body.x: 5.0}"
        given = self._read.mapping(components, "components", like, f"force '{name}'")
        if not given:
            self._note(f"force '{name}' has no components; write {like}.")
        for coordinate, force in given.items():
            if not isinstance(coordinate, Coordinate) or coordinate.letter in MASSES:
                moving = "body.x or joint.angle" if self.in_space else "body.x"
                if isinstance(coordinate, Velocity):
                    moving = dotted(coordinate.coordinate)
                self._note(f"force '{name}': {shown(coordinate)} moves no body; write {moving}.")
                continue
            unit = coordinate.measure.force_unit
            pairs.append((coordinate, self._read.gated(force, unit, f"force '{name}'", when)))
        bodies = self._bodies_in(*(coordinate for coordinate, _ in pairs))
        return self._declare(GeneralizedForce(name, tuple(pairs), bodies))

    @declares(Spring, law="force")
    def spring(
        self, name: str, i: Place, j: Place, stiffness: Any = 0, free_length: Any = None,
        damping: Any = 0, actuator: Any = 0, force: Characteristic | None = None,
        preload: Any = 0,
    ) -> Effect:  # fmt: skip
        """A spring, damper and actuator of two points: f = k (ℓ - ℓ0) + F0 + c ℓ̇ + F (Haug 6.1).

        Parameters
        ----------
        i, j
            Points of two bodies; a body means its centre of mass.
        stiffness, free_length
            k in N/m and ℓ0 in m; a spring needs both.
        damping, actuator
            c in N s/m and F in N, each any expression of t, q, q̇ and parameters; F is positive
            where it pulls the points together.
        force
            Any other law: a function of the length ℓ and its rate ℓ̇ that returns a force in N,
            positive in tension; it is added to the other terms. ``lambda l, v: 5 * (l - 1) ** 3``.
        preload
            F0 in N, the force of the spring at the length ℓ0, positive in tension and negative in
            compression. It needs `free_length`, the length ℓ0.
        """

    @declares(TorsionSpring, law="torque")
    def torsion_spring(
        self, name: str, i: Body, j: Body, stiffness: Any = 0, free_angle: Any = 0,
        damping: Any = 0, actuator: Any = 0, torque: Characteristic | None = None,
        preload: Any = 0,
    ) -> Effect:  # fmt: skip
        """A spring, damper and actuator about the normal: n = k (θ - θ0) + N0 + c θ̇ + N (Haug 6.1).

        Parameters
        ----------
        i, j
            Two bodies; θ = φ_j - φ_i, and n acts on body `i`, -n on body `j`.
        stiffness, free_angle
            k in N m/rad and θ0 in rad.
        damping, actuator
            c in N m s/rad and N in N m, each any expression of t, q, q̇ and parameters.
        torque
            Any other law: a function of the angle θ and its rate θ̇ that returns a torque in N m on
            body `i`; it is added to the other terms.
        preload
            N0 in N m, the torque of the spring on body `i` at the angle θ0.
        """

    @declares(Bushing)
    def bushing(
        self, name: str, i: Place, j: Place, stiffness: tuple[Any, Any, Any] = (0, 0, 0),
        damping: tuple[Any, Any, Any] = (0, 0, 0), free_angle: Any = 0,
    ) -> Effect:  # fmt: skip
        """Springs and dampers between two points along the axes of body `i`, and about the normal.

        Parameters
        ----------
        i, j
            Points that coincide at rest; a body means its centre of mass.
        stiffness
            (k_x, k_y, k_φ) in N/m, N/m and N m/rad.
        damping
            (c_x, c_y, c_φ) in N s/m, N s/m and N m s/rad.
        free_angle
            φ_j - φ_i at rest, rad.
        """

    @declares(Motor, i="from_", j="on")
    def motor(
        self, name: str, on: Body, from_: Body | None = None, *, stall_torque: Any,
        no_load_speed: Any, voltage: Any = 1,
    ) -> Effect:  # fmt: skip
        """A motor whose torque falls in a straight line with its speed, T = T_s (u - ω/ω_0).

        Parameters
        ----------
        on
            The rotor, on which T acts.
        from_
            The stator, on which -T acts; None: the ground. ω = φ̇_on - φ̇_from.
        stall_torque, no_load_speed
            T_s in N m and ω_0 in rad/s, at the rated voltage, both positive.
        voltage
            u, the voltage as a multiple of the rated one: any expression of t, q, q̇ and
            parameters.
        """

    @declares(ElasticBelt)
    def elastic_belt(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *, stiffness: Any,
        damping: Any = 0, pretension: Any = 0, carrier: Body | None = None, crossed: bool = False,
        offset: Any = 0,
    ) -> Effect:  # fmt: skip
        """A belt or chain of two strands that stretch, and pull only, couples two pulleys.

        Parameters
        ----------
        i, j
            The pulleys.
        radius_i, radius_j
            Their radii, m, both positive.
        stiffness, damping
            k = E A/L in N/m and c in N s/m of one strand.
        pretension
            T0 in N, the tension of both strands when the belt is idle.
        carrier
            The body that carries the bearings of both; None: the ground.
        crossed
            Whether the belt is crossed, and turns the pulleys in opposite directions.
        offset
            R_j (φ_j - φ_c) - R_i (φ_i - φ_c) of the idle belt, m. Crossed, R_i counts as negative.
        """

    @declares(GearWithBacklash)
    def gear_with_backlash(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *, backlash: Any,
        stiffness: Any, damping: Any = 0, carrier: Body | None = None, offset: Any = 0,
    ) -> Effect:  # fmt: skip
        """Two gears with play; a spring and a damper act while teeth touch on either flank.

        Parameters
        ----------
        i, j
            The gears.
        radius_i, radius_j
            Radii of the pitch circles, m; negative for an internal gear.
        backlash
            b, the play along the pitch circles from flank to flank, m.
        stiffness, damping
            k in N/m and c in N s/m of the teeth, along the pitch circles.
        carrier
            The body that carries the bearings of both; None: the ground.
        offset
            R_i (φ_i - φ_c) + R_j (φ_j - φ_c) in the middle of the backlash, m.
        """

    @declares(OneWayClutch, i="driver", j="driven")
    def one_way_clutch(self, name: str, driver: Body, driven: Body, capacity: Any = None) -> Effect:
        """A freewheel: `driver` turns `driven` counter-clockwise, and `driven` may overrun it.

        It is rigid: while it grips, both bodies have one speed. If the driver is faster at the
        start or after the impact of a contact, an impact gives both the same speed.

        Parameters
        ----------
        driver, driven
            The bodies i and j of ω_j - ω_i ≥ 0; exchange them for a clutch that drives clockwise.
        capacity
            T_c in N m, the torque at which the clutch slips; None: it never does.
        """
