"""Chains and loops of bodies in space, closed at the drawing because they are drawn closed.

A loop is a word with a letter for each joint on the way from host to host, with a body between one
joint and the next: R revolute, S spherical, U universal, T translational, C cylindrical, W weld,
D a massless link, P planar, I point in plane, L point on line, K strut, A parallel axes, H screw,
X universal with another angle; with massless couplers B revolute-spherical, Q revolute-revolute, Y
revolute-cylindrical, V revolute-translational.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_parts import GROUND

GENERAL = (  # no row depends on others, in general
    "RSSR", "RSUR", "RSCR", "RSUT", "CCCR", "RUUC", "USU", "CSC", "RDR", "RDT", "UDR", "TSSR",
    "CDU", "RRRRRRR", "RUCUR", "RWSUR",
)  # fmt: skip
LINKS = "DBQ"  # that lead to another place
OTHERS = "PILKAHBQYVX"  # in mechanisms of the family of other joints alone
OF_OTHERS = ("RHSP", "RBU", "RKU", "TYS", "RVSR", "HIR", "LUR", "RAS", "XQS", "RPCR", "RQSX")
PARALLEL = ("RRRR", "RRRT", "RCRR", "RSRR")  # axes parallel; a slide lies across them
CONCURRENT = ("RRRR", "RRUR")  # axes through one point
TWICE = ("RR", "WW", "CC", "TT", "SS")  # one body held twice by its host, on one line
KINDS = {
    "S": parts.Spherical, "W": parts.Weld, "R": parts.Revolute, "T": parts.Translational,
    "C": parts.Cylindrical, "U": parts.Universal, "D": parts.SphericalSpherical,
    "P": parts.Planar, "I": parts.PointInPlane, "L": parts.PointOnLine, "K": parts.Strut,
    "A": parts.ParallelAxes, "H": parts.Screw, "B": parts.RevoluteSpherical,
    "Q": parts.RevoluteRevolute, "Y": parts.RevoluteCylindrical,
    "V": parts.RevoluteTranslational, "X": parts.Universal,
}  # fmt: skip


@dataclass
class Drawing:
    """Bodies and joints under construction, with the typical length of 1 m and mass of 1 kg."""

    random: np.random.Generator
    bodies: list[parts.SpatialBody] = field(default_factory=list)
    joints: list[parts.SpatialJoint] = field(default_factory=list)

    @property
    def mechanism(self) -> parts.SpatialMechanism:
        """What has been drawn."""
        return parts.SpatialMechanism(tuple(self.bodies), tuple(self.joints))

    def direction(self) -> Any:
        """A random unit vector."""
        a = self.random.normal(size=3)
        return a / np.linalg.norm(a)

    def near(self, place: Any, reach: float) -> Any:
        """A point at a random distance from another, of about `reach`."""
        return np.asarray(place) + reach * self.random.uniform(0.7, 1.3) * self.direction()

    def host(self, *, ground: bool = True) -> int:
        """A body at random, or the ground."""
        return int(self.random.integers(GROUND if ground else 0, len(self.bodies)))

    def place(self, body: int) -> Any:
        """The centre of a body, or the origin of the ground."""
        return np.zeros(3) if body == GROUND else np.array(self.bodies[body].r)

    def body(self, *points: Any) -> int:
        """A new body about given points, in axes of its own, with products of inertia."""
        mass = float(self.random.uniform(0.5, 2.0))
        sides = self.random.uniform(0.4, 1.2, 3) ** 2
        principal = Rotation.from_quat(self.random.normal(size=4)).as_matrix()
        J = principal @ np.diag(mass / 12.0 * (sides.sum() - sides)) @ principal.T
        A = Rotation.from_quat(self.random.normal(size=4)).as_matrix()
        r = np.mean(points, axis=0) + 0.15 * self.random.normal(size=3)
        inertia: Any = rows(0.5 * (J + J.T))
        name = f"b{len(self.bodies) + 1}"
        self.bodies.append(parts.SpatialBody(name, mass, inertia, vector(r), rows(A)))
        return len(self.bodies) - 1

    def join(self, letter: str, i: int, j: int, at: Any, axis: Any = None, to: Any = None) -> str:
        """A joint by its letter; its axis is random unless given. `to` is the far end of a link."""
        name = f"{letter}{len(self.joints) + 1}"
        kind: Any = KINDS[letter]
        axis = self.direction() if axis is None else np.asarray(axis)
        match letter:
            case "S" | "W":
                joint = kind(name, i, j, vector(at))
            case "D":
                joint = kind(name, i, j, vector(at), vector(to))
            case "U":
                other = np.cross(axis, self.direction())
                joint = kind(name, i, j, vector(at), vector(axis), vector(other))
            case "B" | "Q":
                across = np.cross(np.subtract(to, at), axis)
                joint = kind(name, i, j, vector(at), vector(to), vector(across))
            case "H":
                lead = float(self.random.choice([-1, 1]) * self.random.uniform(0.3, 2.0))
                joint = kind(name, i, j, vector(at), vector(axis), lead)
            case "X" | "Y" | "V":
                other = axis + self.random.uniform(1.0, 2.0) * self.direction()
                joint = kind(name, i, j, vector(at), vector(axis), vector(other))
            case _:
                joint = kind(name, i, j, vector(at), vector(axis))
        self.joints.append(joint)
        return name


def vector(a: Any) -> parts.Vector:
    """Three plain numbers."""
    x, y, z = np.asarray(a, float).tolist()
    return x, y, z


def rows(a: Any) -> parts.Matrix:
    """Three rows of plain numbers."""
    x, y, z = map(vector, a)
    return x, y, z


def add_chain(
    to: Drawing, word: str, ends: tuple[int, int], points: Sequence[Any], axes: Sequence[Any]
) -> list[int]:
    """The bodies of a chain from one host to another, with joints at points and along axes."""
    before, last = ends
    made: list[int] = []
    for k, letter in enumerate(word):
        far = to.near(points[k], 0.5) if letter in LINKS else points[k]
        if k == len(word) - 1:
            body = last
        else:
            body = to.body(far, points[k + 1])
            made.append(body)
        to.join(letter, before, body, points[k], axes[k], far)
        before = body
    return made


def general_loop(to: Drawing, word: str, ends: tuple[int, int]) -> list[int]:
    """Axes in all directions."""
    return add_chain(
        to, word, ends, _on_the_way(to, word, ends, to.direction()), [None] * len(word)
    )


def parallel_loop(to: Drawing, word: str, ends: tuple[int, int], axis: Any) -> list[int]:
    """All axes parallel to `axis`; the points need not lie in one plane."""
    across = np.cross(axis, to.direction())
    points = _on_the_way(to, word, ends, across / np.linalg.norm(across))
    slide = np.cross(axis, to.direction())
    axes = [slide if letter == "T" else axis for letter in word]
    return add_chain(to, word, ends, points, axes)


def _on_the_way(to: Drawing, word: str, ends: tuple[int, int], detour: Any) -> list[Any]:
    begin, end = (to.near(to.place(body), 0.5) for body in ends)
    shares = np.linspace(0.0, 1.0, len(word))[:, None]
    way = (1 - shares) * begin + shares * end + np.sin(np.pi * shares) * detour
    return [*(way + 0.25 * to.random.normal(size=way.shape))]


def concurrent_loop(to: Drawing, word: str, host: int) -> list[int]:
    """All axes through one point, at which a universal joint lies."""
    centre = to.near(to.place(host), 0.5)
    axes = [to.direction() for _ in word]
    reach = [0.0 if letter == "U" else to.random.uniform(0.5, 1.2) for letter in word]
    points = [centre + r * axis for r, axis in zip(reach, axes, strict=True)]
    return add_chain(to, word, (host, host), points, axes)


def twice_held(to: Drawing, word: str, host: int) -> list[int]:
    """A body in two equal joints of one axis on one line."""
    axis, point = to.direction(), to.near(to.place(host), 0.5)
    points = [point, point + to.random.uniform(0.4, 1.0) * axis]
    return add_chain(to, word, (host, host), points, [axis, axis])
