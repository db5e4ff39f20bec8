"""The declaration of a machine in space: ``Model(name, space=True)``.

Its methods have the names of those in the plane, and take three numbers where those take two. The
pose of a body at the drawing is where assembly begins. A joint is declared in global axes at the
drawing, ``at=(x, y, z), axis=(ux, uy, uz)``, or by points and axes of the bodies.
"""

from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np
import sympy

from codegen.declare.drawn_pose import (
    SMALL,
    attitude_of_axes,
    attitude_of_vector,
    rotation_of,
    symbolic,
)
from codegen.declare.element import Effect
from codegen.declare.rotation_entries import conjugate, product
from codegen.declare.space_body import UPRIGHT, SpaceBody, SpaceGround
from codegen.drawing.meshes import Mesh
from codegen.elements.scalar_measures import is_constant
from codegen.elements.space.bushing import TIMES, BushingInSpace, entry_unit
from codegen.errors import ModelError
from codegen.model.space_effects import Place
from codegen.model.space_joints import SpaceJoints
from codegen.readers.values import KindError, members, shown

SPINS = ("omega_x", "omega_y", "omega_z")


class SpaceModel(SpaceJoints):
    """A machine in space; ``Model(name, space=True)`` is one."""

    in_space = True
    _ground_class = SpaceGround

    def body(  # type: ignore[override]
        self, name: str, mass: Any = None, inertia: Any = None, *, at: Any = (0, 0, 0),
        axes: Any = None, draw: Any = None,
    ) -> SpaceBody:  # fmt: skip
        """A rigid body with its centre of mass at its origin.

        Parameters
        ----------
        mass
            In kg; may be left out if only kinematic scenes use the body.
        inertia
            About the centre of mass in body axes, kg m²: three principal moments; six numbers J_xx,
            J_yy, J_zz, J_xy, J_xz, J_yz, entries of the matrix; or the matrix, 3 × 3.
        at
            The centre of mass at the drawing, m, where assembly begins.
        axes
            The body's axes at the drawing: two of them, x' and y', in global numbers, of which y'
            is made perpendicular to x'; or a rotation vector, whose length is the angle in rad; or
            Euler parameters, four numbers. By default the global axes.
        draw
            What draws the body in its frame: an `extruded` outline, a mesh by `read_mesh`, or a
            list of them. Otherwise the picture follows from joints and inertia.
        """
        where = f"body '{name}'"
        m = self._positive(mass, "kg", f"mass of {where}")
        if not (m is None or is_constant(m)):
            self._note(
                f"mass of {where} is {m}; masses that vary are there for machines in the plane "
                "alone so far. Give a number or an expression of parameters."
            )
        j = None if inertia is None else self._inertia(inertia, f"inertia of {where}")
        place = self._vector(at, "m", f"{where}: at")
        attitude = self._attitude(axes, f"{where}: axes")
        forms = self._forms(draw, f"{where}: draw")
        return self._declare(
            SpaceBody(name, m, j, self.token, place=place, attitude=attitude, forms=forms)
        )

    def draw_ground(self, draw: Any) -> None:
        """Draw a frame, a cylinder or the like as part of the ground: forms as in `body`."""
        object.__setattr__(self.ground, "forms", self._forms(draw, "ground: draw"))

    def bushing(  # type: ignore[override]
        self, name: str, i: Place, j: Place, stiffness: Any = (0,) * 6, damping: Any = (0,) * 6,
        preload: Any = (0,) * 6, *, at: Any = None, axes: Any = None,
    ) -> Effect:  # fmt: skip
        """Springs and dampers between two bodies along and about three axes: f = K z + F0 + C ż.

        Parameters
        ----------
        i, j, at
            As of `spherical`: points that coincide at rest, or bodies and a place at the drawing.
        stiffness, damping
            K and C: six numbers, along x, y, z in N/m (N s/m) and about them in N m/rad
            (N m s/rad), or symmetric matrices, 6 × 6, whose other entries are in N (N s).
        preload
            F0 on body `i` where z = 0, as at the drawing: a force in N and a torque in N m.
        axes
            Of the bushing at the drawing, as of `body`; by default the global ones. Those in body
            `i` are the axes of K and C.
        """
        where, ends = f"bushing '{name}'", self._ends(name, i, j, at)
        of_i, of_j = (end.body.attitude for end in ends)
        b = rotation_of(of_i).T @ rotation_of(self._attitude(axes, f"{where}: axes"))
        given = (("stiffness", stiffness), ("damping", damping))
        matrices = {word: self._coupled(value, word, where) for word, value in given}
        bushing: Effect = self._element(
            BushingInSpace, name=name, i=ends[0], j=ends[1], preload=preload,
            axes=sympy.ImmutableMatrix(3, 3, symbolic(b.ravel())),
            drawn=symbolic(product(conjugate(of_j), of_i)), **matrices,
        )  # fmt: skip
        return self._declare(bushing)

    # -- reading -----------------------------------------------------------------------------

    def _coupled(self, value: Any, word: str, where: str) -> sympy.ImmutableMatrix:
        """K or C of a bushing, from six numbers or a matrix."""
        place, time = f"{word} of {where}", TIMES[word]
        try:
            given = members(value.tolist() if isinstance(value, sympy.MatrixBase) else value, 6)
            rows = [[0] * k + [x] + [0] * (5 - k) for k, x in enumerate(given)]
            with suppress(KindError):
                rows = [members(row, 6) for row in given]
        except KindError:
            self._note(
                f"{place} is {shown(value)}; give six numbers, along x, y, z and about them, or a "
                "symmetric matrix, 6 x 6."
            )
            return sympy.ImmutableMatrix.eye(6)
        read = [
            self._value(x, entry_unit(row, column, time), place)
            for row, entries in enumerate(rows)
            for column, x in enumerate(entries)
        ]
        matrix = sympy.ImmutableMatrix(6, 6, read)
        known = matrix.subs(self.defaults)
        if matrix != matrix.T:
            self._note(f"{place} is not symmetric; give a symmetric matrix, as (K + K.T) / 2.")
        elif all(x.is_Float or x.is_Rational for x in known):
            least, *_, most = np.linalg.eigvalsh(np.array(known.tolist(), float))
            if least < -SMALL * abs(most) and min(known.diagonal()) >= 0:
                self._note(
                    f"{place} has the eigenvalue {least:.6g}, in SI units; with a negative one it "
                    "drives the bodies. Check the signs and sizes of its entries that couple."
                )
        return matrix

    def unit_of(self, name: str) -> str | None:
        """As in the plane; rad/s of ``"rod.omega_x"``, a component of ω'."""
        owner, _, letter = name.rpartition(".")
        return "rad/s" if owner in self.bodies and letter in SPINS else super().unit_of(name)

    def _quantities(self) -> list[str]:
        return [*super()._quantities(), *(f"{b}.{spin}" for b in self.bodies for spin in SPINS)]

    def _forms(self, given: Any, where: str) -> tuple[Mesh, ...]:
        """The forms that draw a body."""
        forms = tuple(given) if isinstance(given, list | tuple) else (given,) * (given is not None)
        if all(isinstance(form, Mesh) for form in forms):
            return forms
        self._note(
            f"{where} is {shown(given)}; give what extruded or read_mesh returns, as "
            "extruded(disc(0.1), 0.02), or a list of such forms."
        )
        return ()

    def _inertia(self, value: Any, where: str) -> sympy.ImmutableMatrix:
        """J' from three, six or nine numbers; the unit matrix stands in for others."""
        try:
            given = members(value)
            if len(given) == 3 and not isinstance(given[0], int | float | sympy.Basic | str):
                rows = [members(row, 3) for row in given]
                given = [x for row in rows for x in row]
                read = [self._value(x, "kg m^2", where) for x in given]
                matrix = sympy.ImmutableMatrix(3, 3, read)
                if matrix != matrix.T:
                    self._note(f"{where} is {shown(value)}; give a symmetric matrix.")
                return matrix
            read = [self._value(x, "kg m^2", where) for x in given]
            xx, yy, zz, xy, xz, yz = {3: (*read, 0, 0, 0), 6: (*read,)}[len(read)]
        except (KindError, KeyError):
            self._note(
                f"{where} is {shown(value)}; give three principal moments, six numbers J_xx, J_yy, "
                "J_zz, J_xy, J_xz, J_yz, or a matrix, 3 x 3."
            )
            return sympy.ImmutableMatrix.eye(3)
        return sympy.ImmutableMatrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def _attitude(self, axes: Any, where: str) -> tuple[float, ...]:
        """Euler parameters at the drawing, from what `body` takes."""
        if axes is None:
            return UPRIGHT
        found = None
        with suppress(KindError):
            given = members(axes)
            if len(given) == 2:
                found = attitude_of_axes(*(np.array(self._vector(x, "1", where)) for x in given))
            elif len(given) == 3 and not np.shape(given[0]):
                found = attitude_of_vector(np.array(self._vector(given, "rad", where)))
            elif len(given) == 4:
                p = np.array(self._vector(given, "1", where, 4))
                size = float(np.linalg.norm(p))
                found = tuple((p / size).tolist()) if size > SMALL else None
        if found is None:
            self._note(
                f"{where} is {shown(axes)}; give two axes that are not parallel, a rotation vector "
                "in rad, or four Euler parameters; of a rotation matrix R give R.T[:2]."
            )
        return found or UPRIGHT


ELEMENTS = (
    "body, spherical, revolute, cylindrical, translational, universal, planar, weld, distance, "
    "parallel_axes, point_in_plane, point_on_line, strut, revolute_spherical, revolute_revolute, "
    "revolute_cylindrical, revolute_translational, screw, gear, rack_and_pinion, constraint, "
    "driver, rotation_driver, translation_driver, point_driver, distance_driver, gravity, force, "
    "torque, spring, torsion_spring, bushing, line_force, potential, generalized_force, contact, "
    "stop, friction, dry_friction, release, engage and draw_ground"
)
"""What a machine in space may be declared with, in words."""
MOTOR = "generalized_force(name, {joint.angle: T}) or torsion_spring(name, joint, actuator=-T)"
LIFT = "constraint(name, follower.slide - lift(cam.angle)) of two joints and a table, a spline"
REFUSED = {
    **dict.fromkeys(("clearance_joint", "coupler", "curve_through", "elastic_belt"), ""),
    **dict.fromkeys(("gear_with_backlash", "mass_flow", "one_way_clutch", "particle"), ""),
    **dict.fromkeys(("point_follower", "rolling_disc"), ""),
    **dict.fromkeys(("absolute", "relative"), "constraint"),
    "belt": "gear(name, i, j, ratio=R_i / R_j) of two joints",
    "cam_follower": LIFT,
    "cam_flat_follower": LIFT,
    "motor": MOTOR,
    "relative_driver": "driver, rotation_driver or translation_driver",
}
"""Words of the plane that a machine in space does not have yet, and what to use in their place."""


def _refusal(word: str, instead: str) -> Callable[..., NoReturn]:
    instead = f"Use model.{instead}." if instead else f"In space there are {ELEMENTS}."

    def refuse(self: Any, *_: Any, **__: Any) -> NoReturn:
        raise ModelError(
            f"model.{word}: model '{self.name}' is in space, and this is there for machines in the "
            f"plane alone so far. {instead}"
        )

    refuse.__name__, refuse.__doc__ = word, "Refused for a machine in space."
    return refuse


SpaceModel._unlisted = (*SpaceModel._unlisted, *REFUSED)
for _word, _instead in REFUSED.items():
    setattr(SpaceModel, _word, _refusal(_word, _instead))
