"""The bodies of a declaration: rigid bodies, particles, and couplers.

A coupler is a rod between two pins, taken as heavy as a question needs it (Haug 8.1): as a body, as
a massless link, or as a link with its mass at the pins.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
import sympy

from codegen.declare.area_properties import area_condition, area_properties
from codegen.declare.body import Body, Particle, Point
from codegen.declare.outline_files import read_outline
from codegen.declare.outlines import FEWEST, Outline, polygon, polygon_with_holes
from codegen.declare.symbols import MASSES, Parameter, coordinate
from codegen.declare.value_reader import Reader
from codegen.drawing.plane_geometry import Corner
from codegen.elements.forces.mass_flow import MassLaw
from codegen.elements.scalar_measures import is_constant
from codegen.errors import ModelError
from codegen.model.base import Place
from codegen.model.constraints import Constraints
from codegen.readers.values import KindError, members, shown

Form = Literal["body", "link", "lumped"]
Polygon = tuple[Corner, ...]
Moving = TypeVar("Moving", bound=Body)
FORMS = ("body", "link", "lumped")
_PAIR = 2  # formula: coordinates of a corner


class MovingBodies(Constraints):
    """The bodies, particles and couplers of a declaration."""

    def body(
        self, name: str, mass: Any = None, inertia: Any = None, *, draw: Any = None,
        outline: Any = None, thickness: Any = None, density: Any = None,
    ) -> Body:  # fmt: skip
        """A rigid body with its centre of mass at its origin.

        With an outline, points of the body are given in the axes of the outline's drawing; mass,
        inertia and centre of mass follow. The coordinates x, y are still those of the centre of
        mass, which is at ``center`` in the drawing.

        Parameters
        ----------
        mass, inertia
            Numbers in kg and kg m², pint quantities, parameters or expressions of them; may be left
            out if only kinematic scenes use the body. With an outline, `mass` is the mass of the
            plate, in place of thickness and density. Where they vary, by t, coordinates or tables,
            `mass_flow` says how the matter comes or goes.
        draw
            The outline that draws the body: corners ``[(x', y'), ...]`` of a closed polygon in its
            frame, m, or several outlines; `disc` and `rectangle` return some. Otherwise the outline
            follows from joints and forces.
        outline
            The outline of a plate of one thickness and one material: `polygon`, `bar`, `disc`,
            `rectangle`, or `read_outline` of a DXF or SVG file, with holes; or the corners of a
            polygon. It draws the body, unless `draw` is given.
        thickness, density
            Of the plate, m and kg/m³; may be left out if only kinematic scenes use the body.
        """
        where = f"body '{name}'"
        m = self._positive(mass, "kg", f"mass of {where}")
        j = self._positive(inertia, "kg m^2", f"inertia of {where}")
        rho = self._positive(density, "kg/m^3", f"density of {where}")
        height = self._positive(thickness, "m", f"thickness of {where}")
        polygons = self._outlines(draw, f"{where}: draw")
        if outline is None:
            if density is not None or thickness is not None:
                self._note(f"{where} has a density or a thickness, but no outline; give outline=.")
            return self._declare_body(Body(name, m, j, self.token, outlines=polygons))
        if inertia is not None or (density is None) != (thickness is None) or None not in (m, rho):
            absent = f"{'density' if density is None else 'thickness'}= is missing"
            why = absent if None in (m, rho) else "mass= and density= are both given"
            why = why if inertia is None else "inertia= is given as well"
            self._note(
                f"{where}: {why}; the inertia follows from its outline: give thickness= and "
                "density= beside it, or mass=, or for the picture alone draw= in place of outline=."
            )
        read = self._plate(outline, f"{where}: outline")
        if read is None:
            return self._declare_body(Body(name, m, j, self.token, outlines=polygons))
        plate = area_properties(read, self.defaults)
        per_area = None if m is None else m / plate.size
        if rho is not None and height is not None:
            per_area = rho * height
            m = per_area * plate.size
        j = None if per_area is None else per_area * plate.polar
        cx, cy = plate.center
        polygons = polygons or (polygon_with_holes(read, self.defaults),)
        moved = tuple(tuple((x - cx, y - cy) for x, y in one) for one in polygons)
        asked = (area_condition(read),)
        body = Body(name, m, j, self.token, outlines=moved, center=(cx, cy), conditions=asked)
        return self._declare_body(body)

    def particle(self, name: str, mass: Any = None, *, draw: Any = None) -> Particle:
        """A point mass, with two coordinates and no orientation.

        Parameters
        ----------
        mass, draw
            As in `body`.
        """
        m = self._positive(mass, "kg", f"mass of particle '{name}'")
        outlines = self._outlines(draw, f"particle '{name}': draw")
        return self._declare_body(Particle(name, m, None, self.token, outlines=outlines))

    def draw_ground(self, draw: Any) -> None:
        """Draw a frame, a cylinder or the like as part of the ground: outlines as in `body`."""
        object.__setattr__(self.ground, "outlines", self._outlines(draw, "ground: draw"))

    def coupler(
        self, name: str, i: Place, j: Place, length: Any, mass: Any = None, inertia: Any = None
    ) -> Body:
        """A rod of `length` from a pin at `i` to a pin at `j`; scenes choose its fidelity.

        The body `name` has its centre of mass midway, the pins at x' = ±length/2, and the revolute
        joints ``{name}_i`` and ``{name}_j``. In a scene with ``couplers={name: "link"}`` the
        massless link ``{name}_link`` takes its place. With ``"lumped"`` the particles
        ``{name}_half_i`` and ``{name}_half_j``, half the mass at each pin, are added to this link.
        A body with the inertia m L²/4 moves like the lumped coupler.

        Parameters
        ----------
        i, j
            Points of two bodies; a body means its centre of mass.
        length
            L, m.
        mass, inertia
            As in `body`; the inertia about the centre of mass.
        """
        span = self._value(length, "m", f"length of '{name}'")
        rod = self.body(name, mass, inertia)
        ends = self._point(name, i), self._point(name, j)
        self.revolute(f"{name}_i", ends[0], Point(rod, -span / 2, 0))
        self.revolute(f"{name}_j", Point(rod, span / 2, 0), ends[1])
        self.revolute_revolute(f"{name}_link", *ends, span, instead_of=rod)
        half = None if rod.mass is None else rod.mass / 2
        halves = tuple(self.particle(f"{name}_half_{end}", half) for end in "ij")
        for point, particle in zip(ends, halves, strict=True):
            if point.body.fixed:
                self.absolute(f"{particle.name}_x", particle, "x", point.sx)
                self.absolute(f"{particle.name}_y", particle, "y", point.sy)
            else:
                self.revolute(f"{particle.name}_pin", point, particle.at(0, 0))
        self.couplers[rod.name] = (rod, *halves)
        return rod

    def _declare_body(self, body: Moving) -> Moving:
        """Declare a body; a mass or inertia that varies becomes a coordinate that has a law."""
        owner, given = f"{body.name}_matter", zip(MASSES, (body.mass, body.inertia), strict=True)
        laws = tuple(
            (coordinate(owner, word), law) for word, law in given if law and not is_constant(law)
        )
        if not laws:
            return self._declare(body)
        masses: dict[str, Any] = {q.letter: q for q, _ in laws}
        varying = replace(body, laws=laws, **masses)
        self._declare(MassLaw(owner, varying, self._bodies_in(*(law for _, law in laws))))
        return self._declare(varying)

    def _absent_bodies(
        self, read: Reader, where: str, without: tuple[str, ...], forms: Mapping[str, str],
        analysis: str,
    ) -> tuple[str, ...]:  # fmt: skip
        """Bodies that the forms of the couplers leave out of a scene, and laws of unused masses."""
        laws = [name for name, joint in self.joints.items() if isinstance(joint, MassLaw)]
        absent = laws if analysis == "kinematics" else []
        for name, (rod, *halves) in self.couplers.items():
            form = forms.get(name, "body")
            link = self.joints.get(f"{name}_link")
            ends = [body.name for body in link.bodies] if link else []
            if form != "body":
                absent.append(rod.name)
                pins = (f"{name}_i", f"{name}_j")
                read.problems += [  # joints that would come apart in silence
                    f"{where}: joint '{joint.name}' holds '{name}', which is no body as '{form}'; "
                    "take it as 'body', or leave the joint out."
                    for joint in self.joints.values()
                    if rod in joint.bodies and joint.name not in (*pins, *without)
                ]
            if form != "lumped" or any(end in without for end in ends):
                absent += [half.name for half in halves]
        return tuple(absent)

    def _outlines(self, given: Any, where: str) -> tuple[Polygon, ...]:
        """Closed polygons whose corners are numbers and parameters, m."""
        if given is None:
            return ()

        def entries(of: Any) -> Any:
            pierced = isinstance(of, Outline) and of.holes
            return polygon_with_holes(of, self.defaults) if pierced else members(of)

        try:
            rows = [entries(row) for row in entries(given)]
            is_one = all(
                len(row) == _PAIR and not isinstance(row[0], list | tuple | np.ndarray)
                for row in rows
            )
            outlines = [rows] if is_one else [[members(xy, _PAIR) for xy in row] for row in rows]
        except KindError:
            outlines = [[]]
        if not outlines or min(map(len, outlines)) < FEWEST:
            self._read.note(
                f"{where} is {shown(given)}; give the corners of a polygon, three or more, as "
                "[(0, 0), (1, 0), (0, 1)], or several such lists."
            )
            return ()
        return self._corners(outlines, where) or ()

    def _corners(self, lines: Any, where: str) -> tuple[Polygon, ...] | None:
        """Lists of places, m: numbers, expressions of parameters; None where there are others."""
        before = len(self.problems)
        read = tuple(
            tuple((self._value(x, "m", where), self._value(y, "m", where)) for x, y in line)
            for line in lines
        )
        places = (e for line in read for xy in line for e in xy)
        symbols = {s for e in places for s in e.free_symbols if not isinstance(s, Parameter)}
        if symbols:
            names = ", ".join(sorted(map(str, symbols)))
            self._read.note(
                f"{where} contains {names}; give numbers and expressions of parameters."
            )
        return None if len(self.problems) > before else read

    def _plate(self, given: Any, where: str) -> Outline | None:
        """An outline with its holes; None where it bounds no area."""
        before = len(self.problems)
        try:
            drawn = read_outline(given) if isinstance(given, str | Path) else given
            whole = drawn if isinstance(drawn, Outline) else polygon(drawn)
        except ModelError as error:
            self._read.problems += [f"{where}: {problem}" for problem in error.problems]
            return None
        self._corners([one.vertices for one in (whole, *whole.holes)], where)
        if len(self.problems) == before:
            self._read.problems += area_condition(whole).problems(where, self.defaults)
        return whole if len(self.problems) == before else None

    def _positive(self, value: Any, unit: str, where: str) -> sympy.Expr | None:
        """A mass or inertia, if given; a parameter that is one must be positive from now on."""
        return None if value is None else self._value(value, unit, where, "positive")
