"""The run of a planar machine beside that of the same machine in space."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from codegen import Model
from codegen.declare.scene import Scene
from codegen.elements.joints.points import Distance
from runtime import load
from runtime.results.result import Result
from tests.space.from_plane import NORMAL, Translation, acting_joints, is_keeper

NEAR = 0.01  # s
PLANAR, WRENCH = ("global_fx", "global_fy", "torque"), ("fx", "fy", "fz", "tx", "ty", "tz")


class Pair:
    """A scene in the plane and in space, assembled alike, at the drawing of the plane's start."""

    def __init__(
        self, plane: Model, scene: Scene, turn: Any, origin: Any, folder: Path,
        translation: type[Translation] = Translation,
    ) -> None:  # fmt: skip
        self.turn, self.origin = np.asarray(turn), np.asarray(origin, float)
        self.plane = load(plane, scene, folder=folder)
        self.plane_start = self.plane.assemble()
        columns = self.plane.coordinates
        self.q = dict(zip(columns.names, self.plane_start.q, strict=True))
        rates = (row.velocity for row in columns)
        self.v = dict(zip(rates, self.plane_start.v, strict=True))
        self.translation = translation(plane, scene, self.q, turn, origin)
        self.bodies = [plane.bodies[name] for name in scene.bodies]
        self.joints, self.drivers = acting_joints(plane, scene), scene.drivers
        self.until = {one.name for one in scene.until}
        self.space = load(self.translation.model, scene.name, folder=folder)
        self.space_start = self.space.assemble(guess=self._guess())

    @property
    def size(self) -> float:
        """The largest of the machine's lengths, m: of the places and points of its bodies."""
        places = [abs(x) for name, x in self.q.items() if name.endswith((".x", ".y"))]
        number = self.translation.number
        ends = (end for joint in self.joints if hasattr(joint, "j") for end in (joint.i, joint.j))
        return max(*places, *(abs(number(s)) for end in ends for s in (end.sx, end.sy)))

    def _guess(self) -> dict[str, float]:
        """All coordinates and velocities of the plane's start, in space."""
        rates = {row.name: row.velocity for row in self.space.coordinates}
        own = [
            row
            for row in self.plane.coordinates
            if row.name in rates and not row.name.endswith(".integral")
        ]  # of cams
        found = {row.name: self.q[row.name] for row in own}
        found |= {rates[row.name]: self.v[row.velocity] for row in own}
        for name, ends in self.translation.edges.items():
            if f"{name}.angle" in rates:
                before, after = (self.v.get(f"{end}.omega", 0.0) for end in ends)
                found[rates[f"{name}.angle"]] = after - before
        for body in self.bodies:
            name, made = body.name, self.translation.bodies[body.name]
            place, rate = (
                self.turn @ [of[f"{name}.{x}"], of[f"{name}.{y}"], 0.0]
                for of, x, y in ((self.q, "x", "y"), (self.v, "vx", "vy"))
            )
            found |= {f"{name}.{c}": x for c, x in zip("xyz", place + self.origin, strict=True)}
            found |= {f"{name}.v{c}": x for c, x in zip("xyz", rate, strict=True)}
            p, half = np.array(made.attitude), self.v.get(f"{name}.omega", 0.0) / 2.0
            found |= {f"{name}.e{k}": x for k, x in enumerate(p)}
            turning = half * np.array([-p[3], p[2], -p[1], p[0]])  # ½ Gᵀ (0, 0, ω)
            found |= {rates[f"{name}.e{k}"]: x for k, x in enumerate(turning)}
        return found

    def run(self, end: float, instants: Any, *, space: dict[str, Any], **tight: Any) -> None:
        """Simulate both: the plane by `tight` options, space by these and its own.

        A scene for kinematics has a motion without options.
        """
        options, begin = {"progress": False}, {"start": self.space_start}
        self.known: Result
        self.found: Result
        if self.plane.description.analysis == "kinematics":
            self.known = self.plane.kinematics(end, instants, **options)
            self.found = self.space.kinematics(end, instants, **options | begin)
        else:
            options |= tight
            self.known = self.plane.simulate(end, instants, **options)
            self.found = self.space.simulate(end, instants, **options | begin | space)

    def rest(self) -> None:
        """The positions of rest of both."""
        self.known = self.plane.equilibrium(progress=False)
        self.found = self.space.equilibrium(progress=False)

    def motion_apart(self) -> dict[str, float]:
        """The largest differences of places, of entries of A, and of velocities."""
        known, found, worst = self.known, self.found, {"place": 0.0, "A": 0.0, "v": 0.0}
        for body in self.bodies:
            name, zero = body.name, np.zeros(len(known.t))
            place = np.column_stack([found.q(f"{name}.{c}") for c in "xyz"]) - self.origin
            exact = [known.q(f"{name}.{c}") for c in "xy"]
            off = place @ self.turn - np.column_stack([*exact, zero])
            worst["place"] = max(worst["place"], float(np.abs(off).max()))
            A = self.turn.T @ found.rotation(name)
            angle = known.q(f"{name}.phi") if body.turns else zero
            c, s = np.cos(angle), np.sin(angle)
            off = A[:, :2, 0] - np.column_stack([c, s]), A[:, :, 2] - NORMAL
            worst["A"] = max(worst["A"], *(float(np.abs(one).max()) for one in off))
            speed = found.v(f"{name}.omega_z") - (known.v(f"{name}.omega") if body.turns else zero)
            worst["v"] = max(worst["v"], float(np.abs(speed).max()))
        return worst

    def reactions_apart(self) -> tuple[float, float, float]:
        """The largest difference of force in the plane and torque about its normal, and the sizes.

        The sizes are the largest of the plane, and the largest of the components that the plane
        does not have. At samples 0.01 s or more from singular positions: nearer ones let the
        rounding of lengths grow, to 1e-7 where the plane itself is turned by an angle.
        """
        away = np.ones(len(self.known.t), dtype=bool)
        for position in self.known.singular:
            away &= np.abs(self.known.t - position.time) > NEAR
        worst, largest, across = 0.0, 0.0, 0.0
        for exact, mine in self._reactions():
            assert (np.isnan(exact) == np.isnan(mine[:, [0, 1, 5]])).all()  # of released joints
            if away.any() and not np.isnan(exact).all():
                off = np.abs(mine[:, [0, 1, 5]] - exact)[away]
                worst = max(worst, float(np.nanmax(off)))
                largest = max(largest, float(np.nanmax(np.abs(exact[away]))))
                across = max(across, float(np.nanmax(np.abs(mine[away, 2:5]))))
        return worst, largest, across

    def _reactions(self) -> Iterator[tuple[Any, Any]]:
        """Of each joint that space has, too: the plane's and those of space in the plane's axes."""
        known, found = self.known, self.found
        given = {(row.element, row.component) for row in self.plane.description.reactions}
        for joint in self.joints:
            if is_keeper(joint) or isinstance(joint, Distance):
                name = joint.name
                exact = np.column_stack([
                    known.reaction(name, c) if (name, c.removeprefix("global_")) in given
                    else 0.0 * known.reaction(name, "global_fx") for c in PLANAR
                ])  # fmt: skip
                wrench = np.column_stack([found.reaction(name, c) for c in WRENCH])
                yield exact, np.hstack([wrench[:, :3] @ self.turn, wrench[:, 3:] @ self.turn])

    def multipliers(self) -> Iterator[tuple[Any, Any]]:
        """Of each driver, and of each joint that is its own equations in space, in both."""
        for name in (*(joint.name for joint in self.joints if not is_keeper(joint)), *self.drivers):
            known, found = (
                run.samples.lam[:, [row.element == name for row in machine.description.constraints]]
                for machine, run in ((self.plane, self.known), (self.space, self.found))
            )
            yield known, found
