"""Cams by the motion of their followers: profiles, pressure angles, radii of curvature, undercut.

The centre C(α) of the roller, or the contact of a flat face, is given in axes that do not turn with
the cam, α its angle. With σ = 1 where the cam turns counter-clockwise, else -1, and k × C the
vector C turned by 90°, the tangent of the pitch curve is T = C' - σ k × C, the normal σ k × T.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Body, Curve
from codegen.declare.motion_program import MotionProgram, values_of
from codegen.declare.symbols import alpha
from codegen.declare.value_reader import Reader
from codegen.errors import ModelError
from codegen.readers.calls import declaring, declaring_class
from codegen.readers.values import shown

Numbers = npt.NDArray[np.float64]
_SAMPLES = 1440  # accuracy: of a turn, at which the least radius of curvature is looked for


@declaring_class("CamProfile")
@dataclass(frozen=True, eq=False, repr=False)
class CamProfile(Curve):
    """The profile of a cam, a `Curve` whose parameter α is the angle of the cam, rad.

    `pitch` is the curve of the roller's centre; a point follower on it moves as the roller does.
    In all methods `parameters` are values of those in the profile, by name or symbol, SI.
    """

    pitch: Curve = field(kw_only=True)
    slope: sympy.Expr = field(kw_only=True)  # the pressure angle
    radius: tuple[sympy.Expr, ...] = field(kw_only=True)  # p, q, r: p / q - r, that of the roller r

    def pressure_angle(self, at: Any, parameters: Any = None) -> Numbers:
        """From the follower's way to the normal, counter-clockwise, at angles of the cam, rad."""
        return np.asarray(self._values([self.slope], at, parameters)[0])

    def radius_of_curvature(self, at: Any, parameters: Any = None, pitch: bool = False) -> Numbers:
        """Of the surface or the pitch curve, at angles of the cam, m; negative in hollows."""
        p, q, roller = self._values(self.radius, at, parameters)
        with np.errstate(divide="ignore"):
            return np.asarray(p / q - (0.0 if pitch else roller))

    def undercut(self, parameters: Any = None) -> str:
        """Where the cam is undercut, in a sentence; empty: nowhere."""
        at = np.linspace(0.0, 2.0 * np.pi, _SAMPLES + 1)
        p, q, roller = self._values(self.radius, at, parameters)
        radii = np.where(q > 0.0, p / np.where(q > 0.0, q, 1.0) - roller, np.inf)
        worst = int(np.argmin(radii))
        return "" if radii[worst] > 0.0 else (
            f"the cam is undercut at its angle {np.degrees(at[worst]):.4g}°, where the radius of "
            f"curvature of its surface is {radii[worst]:.3g} m; enlarge the base circle, give the "
            "motion a larger angle, or a smaller roller."
        )  # fmt: skip

    def points(self, count: int = 720, parameters: Any = None) -> Numbers:
        """Points (x', y') of the body on the surface, at equal angles of a turn, m, count × 2."""
        at = np.arange(count) * (2.0 * np.pi / count)
        (cx, cy) = self.body.center
        return self._values([self.x + cx, self.y + cy], at, parameters).T

    def _values(self, expressions: Any, at: Any, parameters: Any) -> Numbers:
        found = values_of(expressions, alpha, at, parameters, repr(self))
        if not np.isfinite(found).all():
            raise ModelError(f"{self!r} has no finite values: the follower does not reach it.")
        return found


@declaring("roller_cam")
def roller_cam(
    cam: Any, lift: Any, base_radius: Any, roller_radius: Any, offset: Any = 0,
    clockwise: bool = False, arm: Any = None, pivot: Any = None, arm_clockwise: bool = False,
) -> CamProfile:  # fmt: skip
    """The profile that moves a roller along a straight line, or swings it on an arm.

    The cam turns about ``cam.at(0, 0)``. At its angle 0 the roller's centre is above this point,
    and rises along y.

    Parameters
    ----------
    lift
        What `motion_program` returns, or an expression of `alpha`: m, or of an arm rad.
    base_radius, roller_radius
        Of the least circle about the cam's centre, and of the roller, m.
    offset
        x of the roller's centre, m.
    clockwise
        Whether the cam turns clockwise; α is the angle by which it has turned.
    arm, pivot, arm_clockwise
        Of an arm: the length from its pivot to the roller's centre, m, (x, y) of the pivot from
        the cam's centre, m, and whether it swings clockwise as it rises.
    """
    read, slides = Reader(), arm is None and pivot is None
    base, rise_by = _length(read, base_radius, "base_radius"), _lift(read, lift, slides)
    if not isinstance(cam, Body):
        read.note(f"cam is {shown(cam)}; give a body.")
    roller, e = _length(read, roller_radius, "roller_radius"), read.value(offset, "m", "offset")
    if slides:
        within = e / (base + roller)
        center = sympy.Matrix([e, sympy.sqrt((base + roller) ** 2 - e**2) + rise_by])
        rise = sympy.Matrix([0, 1])
    else:
        x, y, length = *read.vector(pivot, ("m",) * 2, "pivot", "pivot"), _length(read, arm, "arm")
        if e != 0:
            read.note("offset= is of a roller that slides; leave it out beside arm= and pivot=.")
        sense, apart = -1 if arm_clockwise else 1, sympy.sqrt(x**2 + y**2)
        within = (length**2 + apart**2 - (base + roller) ** 2) / (2 * length * apart)
        angle = sympy.atan2(-y, -x) + sense * (sympy.acos(within) + rise_by)
        out = sympy.Matrix([sympy.cos(angle), sympy.sin(angle)])
        center, rise = sympy.Matrix([x, y]) + length * out, sense * _quarter(out)
    if not read.problems and (1 - within**2).is_nonnegative is False:
        read.note("the roller reaches no base circle of this radius with this offset or arm.")
    if read.problems:
        raise ModelError([f"roller_cam: {problem}" for problem in read.problems])
    way = -1 if clockwise else 1
    tangent = center.diff(alpha) - way * _quarter(center)
    normal, size = way * _quarter(tangent), sympy.sqrt(tangent.dot(tangent))
    bend = tangent.diff(alpha) - way * _quarter(tangent)
    surface = _turned(cam, center - roller * normal / size, way)
    return CamProfile(
        cam, surface.x, surface.y, pitch=_turned(cam, center, way),
        slope=sympy.atan2(way * rise.dot(tangent), rise.dot(normal)),
        radius=(size**3, -bend.dot(normal), roller),
    )  # fmt: skip


@declaring("flat_faced_cam")
def flat_faced_cam(
    cam: Any, lift: Any, base_radius: Any, clockwise: bool = False
) -> CamProfile:  # fmt: skip
    """The profile that moves a flat face, which is parallel to x, along y; see `roller_cam`."""
    read, way = Reader(), -1 if clockwise else 1
    base, rise = _length(read, base_radius, "base_radius"), _lift(read, lift)
    if not isinstance(cam, Body):
        read.note(f"cam is {shown(cam)}; give a body.")
    if read.problems:
        raise ModelError([f"flat_faced_cam: {problem}" for problem in read.problems])
    contact = sympy.Matrix([way * rise.diff(alpha), base + rise])
    curve, zero = _turned(cam, contact, way), sympy.S.Zero
    radius = base + rise + rise.diff(alpha, 2), sympy.S.One, zero
    return CamProfile(cam, curve.x, curve.y, pitch=curve, slope=zero, radius=radius)


def _lift(read: Reader, lift: Any, slides: bool = True) -> sympy.Expr:
    unit = "m" if slides else "rad"
    if isinstance(lift, MotionProgram) and (lift.unit, lift.value_unit) != ("rad", unit):
        read.note(f"lift is in {lift.value_unit} over {lift.unit}; give {unit} over an angle.")
    return read.value(lift(alpha) if callable(lift) else lift, unit, "lift", profile=True)


def _length(read: Reader, value: Any, where: str) -> sympy.Expr:
    length = read.value(value, "m", where)
    if length.is_negative or (length == 0 and where == "base_radius"):
        read.note(f"{where} is {shown(value)}; give a length that is more than 0.")
    return length


def _quarter(vector: sympy.Matrix) -> sympy.Matrix:
    """k × the vector: turned by 90°, counter-clockwise."""
    return sympy.Matrix([-vector[1], vector[0]])


def _turned(cam: Body, place: sympy.Matrix, way: int) -> Curve:
    """The curve in the cam of a place in axes that do not turn."""
    c, s = sympy.cos(alpha), way * sympy.sin(alpha)
    return cam.curve(c * place[0] + s * place[1], c * place[1] - s * place[0])
