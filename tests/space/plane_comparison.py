"""The run of a planar machine beside that of the same machine in space."""

from pathlib import Path
from typing import Any

import numpy as np

from codegen import Model
from codegen.elements.joints.guides import Translational
from codegen.elements.joints.points import Revolute
from runtime import load
from runtime.results.result import Result
from tests.space.from_plane import NORMAL, Translation, acting_joints

NEAR = 0.01  # s
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")


class Pair:
    """A scene in the plane and in space, assembled alike, at the drawing of the plane's start."""

    def __init__(self, plane: Model, scene: str, turn: Any, folder: Path) -> None:
        self.turn, self.folder = np.asarray(turn), folder
        self.plane = load(plane, scene, folder=folder)
        self.plane_start = self.plane.assemble()
        columns = self.plane.coordinates
        self.q = dict(zip(columns.names, self.plane_start.q, strict=True))
        rates = (row.velocity for row in columns)
        self.v = dict(zip(rates, self.plane_start.v, strict=True))
        self.translation = Translation(plane, scene, self.q, turn)
        self.joints = acting_joints(plane, plane.scenes[scene])
        self.space = load(self.translation.model, scene, folder=folder)
        self.space_start = self.space.assemble(guess=self._guess())

    def _guess(self) -> dict[str, float]:
        """All coordinates and velocities of the plane's start, in space."""
        found: dict[str, float] = {}
        for name, body in self.translation.bodies.items():
            place, rate = (
                self.turn @ [of[f"{name}.{x}"], of[f"{name}.{y}"], 0.0]
                for of, x, y in ((self.q, "x", "y"), (self.v, "vx", "vy"))
            )
            found |= {f"{name}.{c}": x for c, x in zip("xyz", place, strict=True)}
            found |= {f"{name}.v{c}": x for c, x in zip("xyz", rate, strict=True)}
            p, half = np.array(body.attitude), self.v[f"{name}.omega"] / 2.0
            found |= {f"{name}.e{k}": x for k, x in enumerate(p)}
            turning = half * np.array([-p[3], p[2], -p[1], p[0]])  # ½ Gᵀ (0, 0, ω)
            rows = [row for row in self.space.coordinates if row.name.startswith(f"{name}.e")]
            found |= {row.velocity: x for row, x in zip(rows, turning, strict=True)}
        return found

    def run(self, end: float, instants: Any, *, space: dict[str, Any], **tight: Any) -> None:
        """Simulate both: the plane by `tight` options, space by these and its own."""
        options = {"progress": False, **tight}
        self.known: Result = self.plane.simulate(end, instants, **options)
        self.found: Result = self.space.simulate(
            end, instants, start=self.space_start, **options | space
        )

    def motion_apart(self) -> dict[str, float]:
        """The largest differences of places, of entries of A, and of velocities."""
        known, found, worst = self.known, self.found, {"place": 0.0, "A": 0.0, "v": 0.0}
        for name in self.translation.bodies:
            place = np.column_stack([found.q(f"{name}.{c}") for c in "xyz"]) @ self.turn
            exact = [known.q(f"{name}.{c}") for c in "xy"]
            off = place - np.column_stack([*exact, np.zeros(len(place))])
            worst["place"] = max(worst["place"], float(np.abs(off).max()))
            A, angle = self.turn.T @ found.rotation(name), known.q(f"{name}.phi")
            c, s = np.cos(angle), np.sin(angle)
            off = A[:, :2, 0] - np.column_stack([c, s]), A[:, :, 2] - NORMAL
            worst["A"] = max(worst["A"], *(float(np.abs(one).max()) for one in off))
            speed = found.v(f"{name}.omega_z") - known.v(f"{name}.omega")
            worst["v"] = max(worst["v"], float(np.abs(speed).max()))
        return worst

    def reactions_apart(self) -> tuple[float, float]:
        """The largest difference of fx, fy and the torque about the normal, and the largest.

        Of hinges and sliders, at samples 0.01 s or more from singular positions: nearer ones let
        the rounding of lengths grow, to 1e-7 where the plane itself is turned by an angle.
        """
        known, found, worst, largest = self.known, self.found, 0.0, 0.0
        away = np.ones(len(known.t), dtype=bool)
        for position in known.singular:
            away &= np.abs(known.t - position.time) > NEAR
        given = {(row.element, row.component) for row in self.plane.description.reactions}
        for joint in self.joints:
            if not isinstance(joint, Revolute | Translational):
                continue
            axis = np.array(getattr(joint, "axis", (1.0, 0.0)), float)
            angle = np.arctan2(axis[1], axis[0])
            if not joint.i.body.fixed:
                angle = angle + known.q(f"{joint.i.body.name}.phi")
            parts = {c: known.reaction(joint.name, c) if (joint.name, c) in given
                     else np.zeros(len(known.t)) for c in ("fx", "fy", "torque")}  # fmt: skip
            c, s = np.cos(angle), np.sin(angle)
            exact = np.column_stack([
                c * parts["fx"] - s * parts["fy"], s * parts["fx"] + c * parts["fy"],
                parts["torque"],
            ])  # fmt: skip
            wrench = np.column_stack([found.reaction(joint.name, c) for c in WRENCH])
            force, torque = wrench[:, :3] @ self.turn, wrench[:, 3:] @ self.turn
            mine = np.column_stack([force[:, :2], torque[:, 2]])
            worst = max(worst, float(np.abs(mine - exact)[away].max()))
            largest = max(largest, float(np.abs(exact)[away].max()))
        return worst, largest
