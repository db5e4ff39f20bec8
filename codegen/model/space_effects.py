"""Drivers, gears and forces of machines in space, with the names of those in the plane."""

from typing import Any, Literal

import sympy

from codegen.declare.element import Constraint, Effect, label
from codegen.declare.space_body import SpaceBody, SpacePoint, Three
from codegen.elements.space.drivers import PointDriverInSpace
from codegen.elements.space.forces import (
    ForceInSpace,
    GravityInSpace,
    TorqueInSpace,
    TorsionSpringInSpace,
)
from codegen.elements.space.friction import JointFrictionInSpace
from codegen.elements.space.joints import JointInSpace
from codegen.elements.space.transmissions import GearInSpace, RackInSpace
from codegen.model.base import declares
from codegen.model.contacts import FrictionLaw
from codegen.model.forces import Characteristic
from codegen.model.model import Model
from codegen.readers.values import shown

Place = SpacePoint | SpaceBody  # a body means its centre of mass, or its place at the drawing


class SpaceEffects(Model):
    """Drivers, gears and forces of a declaration in space."""

    @declares(GravityInSpace)
    def gravity(self, name: str, g: Three) -> Effect:  # type: ignore[override]
        """Uniform gravity (g_x, g_y, g_z), m/s², on every body of the scene."""

    def rotation_driver(self, name: str, joint: Constraint, law: Any) -> Constraint:  # type: ignore[override]
        """The angle of a joint, such as a revolute one, follows a law of the time, rad.

        Its reaction is the torque on the joint's second body about the axis, N m.
        """
        return self.driver(name, self._of_joint(name, joint, "angle"), law)

    def translation_driver(self, name: str, joint: Constraint, law: Any) -> Constraint:  # type: ignore[override]
        """The slide of a joint, such as a translational one, follows a law of the time, m.

        Its reaction is the force on the joint's second body along the axis, N.
        """
        return self.driver(name, self._of_joint(name, joint, "slide"), law)

    @declares(PointDriverInSpace, point="on")
    def point_driver(  # type: ignore[override]
        self, name: str, on: Place, letter: Literal["x", "y", "z"], law: Any
    ) -> Constraint:
        """A point of a body follows a law of the time along a global axis, m."""

    def gear(  # type: ignore[override]
        self, name: str, i: Constraint, j: Constraint, ratio: Any, *, offset: Any = 0
    ) -> Constraint:
        """Two wheels mesh: the angle of joint `j` is `ratio` times that of joint `i`.

        The wheels turn in these joints, such as `revolute` ones, on one carrier: each joint has
        it, or the ground, as one of its two bodies. `ratio` is no pair of radii as in the plane: it
        is ± R_i/R_j, negative where one angle decreases as the other grows. `offset`, rad, is the
        angle of `j` where that of `i` is 0.
        """
        return self._teeth(GearInSpace, name, (i, j), {"ratio": ratio, "offset": offset})

    def rack_and_pinion(  # type: ignore[override]
        self, name: str, pinion: Constraint, rack: Constraint, radius: Any, *, offset: Any = 0
    ) -> Constraint:
        """A pinion drives a rack: the slide of `rack` is `radius` times the angle of `pinion`.

        These are joints. `radius`, m, is negative where the slide decreases as the angle grows;
        `offset`, m, is the slide where the angle is 0.
        """
        return self._teeth(RackInSpace, name, (pinion, rack), {"radius": radius, "offset": offset})

    def _teeth(self, cls: type[Any], name: str, pair: Any, given: dict[str, Any]) -> Constraint:
        renamed = {"ratio": next(iter(given))}
        rows = zip(("angle", "driven"), pair, ("angle", cls.letter), strict=True)
        given |= {word: self._of_joint(name, joint, letter) for word, joint, letter in rows}
        teeth: Constraint = self._element(cls, renamed, name=name, **given)
        return self._declare(teeth)

    def torsion_spring(  # type: ignore[override]
        self, name: str, joint: Constraint, stiffness: Any = 0, free_angle: Any = 0,
        damping: Any = 0, actuator: Any = 0, torque: Characteristic | None = None,
        preload: Any = 0,
    ) -> Effect:  # fmt: skip
        """A spring, damper and actuator of a joint's angle: n = k (θ - θ0) + N0 + c θ̇ + N.

        Parameters
        ----------
        joint
            A joint with an angle; n acts on its first body, -n on its second.
        stiffness, free_angle, damping, actuator, torque, preload
            As in the plane.
        """
        element: Effect = self._element(
            TorsionSpringInSpace, {"law": "torque"}, name=name, stiffness=stiffness,
            angle=self._of_joint(name, joint, "angle"), free_angle=free_angle, damping=damping,
            actuator=actuator, torque=torque, preload=preload,
        )  # fmt: skip
        return self._declare(element)

    def friction(  # type: ignore[override]
        self, name: str, joint: Constraint, coefficient: Any, creep: Any = None, radius: Any = None,
        length: Any = None, static: Any = None, fidelity: FrictionLaw | None = None,
        collar: Any = None,
    ) -> Effect:  # fmt: skip
        """Coulomb friction in a joint, from the joint's reaction.

        Parameters
        ----------
        joint
            A revolute, translational or cylindrical joint.
        coefficient, creep, static, fidelity
            As in the plane; a cylindrical joint needs `creep`, in m/s, and does not stick.
        radius
            The radius of a pin, m; of a translational joint that at which the torque about its axis
            presses, or None: it does not press.
        length
            The length of the bearing, m: the moment then presses on both ends.
        collar
            The mean radius of the thrust face of a revolute joint, m, on which the force along its
            axis presses; None: it does not rub.
        """
        law: JointFrictionInSpace = self._element(
            JointFrictionInSpace, name=name, joint=joint, coefficient=coefficient, creep=creep,
            radius=radius, length=length, static=static, collar=collar,
        )  # fmt: skip
        self._note_foreign(name, joint)
        return self._friction_law(law, fidelity)

    @declares(ForceInSpace, point="on")
    def force(  # type: ignore[override]
        self, name: str, on: Place, value: Three, frame: Literal["ground", "body"] = "ground",
        when: Any = None, label: str = "",
    ) -> Effect:  # fmt: skip
        """A force (fx, fy, fz) in N at a point of a body.

        Parameters
        ----------
        on
            The point at which it acts; a body means its centre of mass.
        value
            In N, any expressions of t, q, q̇ and parameters.
        frame
            ``"ground"`` for global axes, ``"body"`` for those of the body.
        when, label
            As in the plane.
        """

    @declares(TorqueInSpace, body="on")
    def torque(  # type: ignore[override]
        self, name: str, on: SpaceBody, value: Three, frame: Literal["ground", "body"] = "ground",
        when: Any = None, label: str = "",
    ) -> Effect:  # fmt: skip
        """A torque (tx, ty, tz) in N m on a body; words as of `force`."""

    def _of_joint(self, name: str, joint: Any, letter: str) -> Any:
        """A coordinate of a joint; 1 stands in for one that there is not."""
        if isinstance(joint, JointInSpace) and self.joints.get(joint.name) is joint:
            return getattr(joint, letter)
        what = label(joint) if isinstance(joint, Constraint | SpaceBody) else shown(joint)
        one, like = ("an", "revolute") if letter == "angle" else ("a", "translational")
        self._note(
            f"'{name}': {what} is no joint of '{self.name}' with {one} {letter}; give what "
            f"model.{like}(...) or model.cylindrical(...) returned."
        )
        return sympy.S.One
