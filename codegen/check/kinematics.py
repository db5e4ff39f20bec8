"""Kinematics of a scene before it is compiled.

Whether its constraints are independent: at positions near the start values, in which the joints
close, orthogonalisation finds the rows of Φ_q that depend on earlier ones (Haug 3.4). Drivers stand
last, so that a driver that repeats a joint is the one named.

How joints hold a body: revolute joints, all at one point, or one joint alone. Both may be meant.
Where a linkage does not close or has a freedom too many, they are often a point with a wrong sign,
or a joint that was forgotten.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.declare.body import Body, Point
from codegen.derive.equations import Equations
from codegen.lower.lowered_scene import Lowered
from codegen.lower.poses_near_start import Poses, dependent_rows, is_finite
from codegen.model import Model

Array = npt.NDArray[np.float64]
# accuracy: rest of a row, columns scaled, below which the row follows from those before it
TOLERANCE = 1e-8
# safety: positions about the start that are tried, so that a singular start is not redundancy
PROBES = 3
# measured: of the machine's size, distances of a probe from the start; nearer ones where its joints
# do not close
DISTANCES = (0.1, 0.03, 0.01)
FREEDOMS = 3  # formula: of a body in the plane; in space twice as many


class Findings(NamedTuple):
    """Findings about the constraints of a scene."""

    coordinates: int  # without states
    constraints: int
    dependent: tuple[int, ...]  # constraints that follow from others
    problems: tuple[str, ...] = ()  # drivers that have nothing left to drive
    notes: tuple[str, ...] = ()
    """Joints that repeat each other: a run bears with them while their parameters agree."""

    @property
    def degrees_of_freedom(self) -> int:
        """Redundant constraints take none away."""
        return self.coordinates - self.constraints + len(self.dependent)


def examine(model: Model, equations: Equations, lowered: Lowered) -> Findings:
    """Look for constraints that are too many near the start values."""
    rows = [(c, row) for c in equations.constraints for row in c.statement.rows]
    kept = np.array([float(not c.driver) for c, _ in rows])
    numbers = tuple(_least_dependent(Poses(lowered), kept)) if rows else ()
    dependent = [rows[i] for i in numbers]
    positions = len(equations.coordinates) - len(equations.states)
    found = Findings(positions, len(rows), numbers)
    if not dependent:
        return found
    redundant = ", ".join(f"{c.name}.{row} ({c.kind})" for c, row in dependent)
    head = (
        f"scene '{equations.scene.name}': {len(rows)} constraints on {positions} coordinates, of "
        f"which only {len(rows) - len(dependent)} are independent; redundant: {redundant}."
    )
    by, drivers = _held_by_rounding(lowered, kept), {c.name for c, _ in dependent if c.driver}
    names = " or ".join(map(repr, sorted(drivers or {c.name for c, _ in dependent})))
    if drivers:
        pairs = {name: frozenset(joint.bodies) for name, joint in model.joints.items()}
        held = Counter(pairs[c.name] for c, _ in rows if c.name in pairs)
        most = FREEDOMS * (2 if model.in_space else 1)
        twice = (c.name for c, _ in rows if c.name in pairs and held[pairs[c.name]] > most)
        both = " and ".join(dict.fromkeys(twice))
        problem = head + (by or f" Remove or relax {names}: no motion is left for them to prevent.")
        if both:
            problem = f"{head} Joints {both} hold the same bodies: remove one of them."
        return found._replace(problems=(problem,))
    note = (
        f"{head}{by} The scene runs as long as its parameters let them agree, and reactions of "
        f"joints that share a load are not unique. Remove or relax {names} to make them so."
    )
    return found._replace(notes=(note,))


def _least_dependent(poses: Poses, kept: Array) -> list[int]:
    """The rows that depend on earlier ones where they are fewest.

    Of as many, the last ones: at a singular position an earlier row depends on others by chance.
    A probe without any is the last one. `kept`, (m,), is 0 for the rows of drivers: what they hold
    in place moves in a probe.
    """
    probes = []
    for jacobian in _jacobians_near_start(poses, kept):
        probes.append(_dependent_rows(jacobian))
        if not probes[-1]:
            break
    return min(probes, key=lambda rows: (len(rows), [-i for i in rows]))


def _jacobians_near_start(poses: Poses, kept: Array) -> Iterator[Any]:
    """Φ_q in units of the machine's size, at positions of the motion; sparse for a large machine.

    A loop in space has its redundant rows only where it closes. Where the start does not, the
    position that comes nearest may be singular, as a rod that is stretched after what it cannot
    reach: then Φ_q is that of places where a search begins.
    """
    start = poses.start() or poses.start(kept)
    near, jacobian = start or (poses.guess, poses.scaled(poses.jacobian(poses.guess), poses.unit))
    yield _finite(jacobian)
    for k in range(1, PROBES):
        away = np.random.default_rng(k).standard_normal(len(near))
        if start:
            away = poses.allowed(jacobian, away, kept)
        begins = [near + size * poses.unit * away for size in DISTANCES]
        places = (poses.closed_near(begin, kept=kept) for begin in begins)
        found = next((by for q, by in places if poses.holds(q, kept)), None)
        if found is None and not start:
            found = poses.scaled(poses.jacobian(begins[0]), poses.unit)
        if found is not None:
            yield _finite(found)


def _held_by_rounding(lowered: Lowered, kept: Array) -> str:
    """A sentence on joints in space that exact numbers would leave a motion; or nothing."""
    if not lowered.description.turning:
        return ""
    rows = next(_jacobians_near_start(Poses(lowered), kept))[kept > 0.0]
    if not isinstance(rows, np.ndarray):
        return ""
    lengths = np.linalg.norm(rows, axis=1).clip(1e-300)  # safety: a row of zeros
    values = np.linalg.svd(rows / lengths[:, None], compute_uv=False)
    values = values[values > 2e-11]  # measured: above that of numbers of ten digits
    if len(values) < rows.shape[1]:
        return ""  # free to move
    *_, other, least = 1.0, 1.0, *values
    return bool(least < min(1e-3, 0.01 * other)) * (  # measured: three digits, apart from others
        f" The joints hold a motion by a singular value of only {least:.1g}, and "
        "would leave it free if axes and points were exact: compute these rather than round them "
        "(ten digits are enough), or use a joint with fewer equations."
    )


def _finite(jacobian: Any) -> Any:
    """The matrix; one of random numbers in its place where a number is not finite."""
    if is_finite(jacobian):
        return jacobian
    random = np.random.default_rng(0)
    if isinstance(jacobian, np.ndarray):
        return random.standard_normal(jacobian.shape)
    jacobian.data = random.standard_normal(jacobian.data.size)
    return jacobian


def _dependent_rows(jacobian: Any) -> list[int]:
    """Rows that depend on earlier ones, by Gram-Schmidt, each row orthogonalised twice.

    Those of a sparse matrix follow from its left null vectors.
    """
    if not isinstance(jacobian, np.ndarray):
        return dependent_rows(jacobian, TOLERANCE)
    basis = np.zeros((0, jacobian.shape[1]))
    dependent = []
    for i, row in enumerate(jacobian):
        rest = row / max(float(np.linalg.norm(row)), 1e-300)  # safety: a row of zeros
        for _ in range(2):
            rest = rest - basis.T @ (basis @ rest)
        size = float(np.linalg.norm(rest))
        if size > TOLERANCE:
            basis = np.vstack([basis, rest / size])
        else:
            dependent.append(i)
    return dependent


_SAME = 1e-9  # accuracy: of a point's distance from its body's origin; nearer places are one


def one_joint_bodies(model: Model, left_out: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """The bodies that one joint alone holds, each with the joint; without the joints left out."""
    return tuple(
        (body.name, joints[0])
        for body, joints in _joints_of_bodies(model, left_out)
        if len(joints) == 1
    )


def joints_at_one_point(model: Model) -> tuple[str, ...]:
    """A sentence for each body that revolute joints alone hold, all at the same point of it."""
    found = []
    for body, joints in _joints_of_bodies(model, ()):
        pins = [name for name in joints if model.joints[name].kind == "revolute"]
        places = [place for name in pins for place in places_on(model, name, body)]
        size = max((float(np.hypot(*place)) for place in places), default=0.0)
        if len(places) == len(joints) > 1 and float(np.ptp(places, axis=0).max()) <= _SAME * size:
            x, y = places[0]
            found.append(
                f"Joints {' and '.join(joints)} hold body '{body.name}' at one point, "
                f"({x:.4g}, {y:.4g}): is one of the signs wrong?"
            )
    return tuple(found)


def _joints_of_bodies(
    model: Model, left_out: Sequence[str]
) -> Iterator[tuple[Body, tuple[str, ...]]]:
    acting = {name: j for name, j in model.joints.items() if name not in left_out}
    for body in model.bodies.values():
        if not body.fixed:
            yield body, tuple(name for name, j in acting.items() if body in j.bodies)


def places_on(model: Model, joint: str, body: Body) -> Iterator[tuple[float, float]]:
    """The points of a body that a joint is attached to, m, where they are numbers."""
    for point in vars(model.joints[joint]).values():
        if isinstance(point, Point) and point.body is body:
            x, y = (value.subs(model.defaults) for value in point.place)
            if x.is_finite and x.is_real and y.is_finite and y.is_real:
                yield float(x), float(y)
