"""What happens at a kink of an explicit function of time: nothing, an event, an impact, or the end.

The kernels say it themselves: they are called on both sides of the instant, at one state.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.modes_and_event_kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.explicit_time.instants import Kink, TimeInstants
from runtime.integrate.problem import Passage, Stops
from runtime.mechanism.dense_equations import Equations

_FAR = 1000.0  # safety: distances of a kink's sides from it; there a pole has not begun
_GROWTH = 300.0  # safety: of a value from there to its side; that of a pole is 1000
_GREAT = 1e3  # safety: of its size; a smaller value is not that of a pole
_ADVICE = (
    ": look for a table evaluated beyond its ends, a division by zero, or a root or logarithm of "
    "what is not positive"
)
_JUMP = 1e-9  # accuracy: of the typical size; a smaller jump is rounding


class Passages:
    """The kinks of a machine's explicit functions of time, and how a motion passes them."""

    def __init__(
        self, equations: Equations, instants: TimeInstants, q: Vector, v: Vector, sizes: Vector
    ) -> None:
        self.equations, self.instants, self.start = equations, instants, (q, v)
        self.size = float(sizes.max(initial=1.0))

    def stops(self) -> Stops | None:
        """The instants at which the steps of a run end."""
        bounds, kinks, crowd = self.instants
        rows = [(float(t), -1, float(t)) for t in bounds]
        rows += [(kink.before, k, kink.after) for k, kink in enumerate(kinks)]
        if crowd is not None:
            rows.append((crowd[0], len(kinks), crowd[0]))
        if not rows:
            return None
        times, numbers, after = zip(*sorted(rows), strict=True)
        return Stops(np.array(times), np.array(numbers, np.int64), np.array(after), self.passage)

    def passage(self, number: int, q: Vector, v: Vector, modes: Integers) -> Passage:
        """How a motion passes the kink of that number in the state (q, v), under `modes`.

        In fewer coordinates than the machine's own the state at the start stands for it.
        """
        if number == len(self.instants.kinks):
            return self._crowded()
        kink, equations = self.instants.kinks[number], self.equations
        reduced = len(q) != equations.n
        q, v = self.start if reduced else (q, v)
        slides = bool(np.any(modes == SLIDING))
        modes = np.where(modes == SLIDING, 0, modes)
        sides = [self._values(t, q, v, modes) for t in kink[:2]]
        if ended := self._without_bound(kink, sides, q, v, modes):
            return ended
        (phi, nu, *others), (phi_after, nu_after, *others_after) = sides
        apart = kink.after - kink.before
        jumps = np.abs(phi_after - phi) - 2.0 * apart * np.maximum(np.abs(nu), np.abs(nu_after))
        if np.any(jumps > _JUMP * self.size):
            row = int(jumps.argmax())
            size = abs(float(phi_after[row] - phi[row]))
            return self._end(kink, f"jumps by {size:.6g} at t = {kink.after:.9g} s", row)
        speeds = np.maximum(np.abs(nu), np.abs(nu_after))
        jumps = np.abs(nu_after - nu) - _JUMP * np.maximum(speeds, self.size)
        if np.any(jumps > 0.0):
            row = int(jumps.argmax())
            size = abs(float(nu_after[row] - nu[row]))
            text = f"has a rate that jumps by {size:.6g} a second at t = {kink.after:.9g} s"
            if reduced:
                text += ", an impact, for which reduced coordinates have no equations"
                return self._end(kink, text, row, 'Take formulation="cartesian". ')
            if slides:
                text += ", while a contact is closed or friction sticks"
                return self._end(kink, text, row)
            return Passage(v=self._velocities(kink.after, q, v, nu_after), event=Direction.IMPACT)
        pairs = zip(others, others_after, strict=True)
        bends = any(not np.allclose(a, b, rtol=_JUMP, atol=_JUMP) for a, b in pairs)
        return Passage(event=Direction.BEGAN if bends else None)

    def _values(self, t: float, q: Vector, v: Vector, modes: Integers) -> list[Vector]:
        """Φ, ν, γ and the applied forces."""
        equations = self.equations
        values = [equations.constraints(t, q), equations.velocity_rhs(t, q)]
        values.append(equations.acceleration_rhs(t, q, v))
        if equations.description.has_masses:
            values.append(equations.forces(t, q, v, modes))
        return values

    def _without_bound(
        self, kink: Kink, sides: list[list[Vector]], q: Vector, v: Vector, modes: Integers
    ) -> Passage | None:
        """The end of a run where a function grows without bound, or has no value behind."""
        far = _FAR * 0.5 * (kink.after - kink.before)
        for side, way in zip(sides, (-far, far), strict=True):
            there = self._values(0.5 * (kink.before + kink.after) + way, q, v, modes)
            for order, (near, distant) in enumerate(zip(side, there, strict=True)):
                grown = np.abs(near) > np.maximum(_GROWTH * np.abs(distant), _GREAT * self.size)
                bad = ~np.isfinite(near) | (
                    (order != 2) & grown
                )  # γ may grow, but not its integral
                if bad.any():
                    row = int(bad.argmax()) if order < 3 else -1
                    text = f"has no finite {'rate' if order in (1, 2) else 'value'}"
                    text += f" at t = {kink.after:.9g} s{_ADVICE}"
                    return self._end(kink, text, row)
        return None

    def _end(self, kink: Kink, what: str, row: int, more: str = "") -> Passage:
        note = f"A function of time in '{kink.element}' {what}. {more}"
        return Passage(Outcome.DISCONTINUOUS, row, note.rstrip())

    def _crowded(self) -> Passage:
        assert self.instants.crowd is not None
        begin, end, element = self.instants.crowd
        note = (
            f"A function of time in '{element}' changes ever faster up to about t = {end:.9g} s, "
            f"infinitely often; from t = {begin:.9g} s on its changes cannot be told apart."
        )
        return Passage(Outcome.ZENO, note=note)

    def _velocities(self, t: float, q: Vector, v: Vector, nu: Vector) -> Vector:
        """Velocities after an impact of the drivers: M Δv + Φ_qᵀ Λ = 0, Φ_q (v + Δv) = ν."""
        n, jacobian = self.equations.n, self.equations.jacobian(t, q)
        matrix = np.block(
            [
                [self.equations.mass(q), jacobian.T],
                [jacobian, np.zeros((len(jacobian), len(jacobian)))],
            ]
        )
        right = np.concatenate([np.zeros(n), nu - jacobian @ v])
        change: Vector = np.linalg.lstsq(matrix, right, rcond=None)[0][:n]
        return v + change
