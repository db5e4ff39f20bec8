"""The effect of a kink of an explicit function of time: none, an event, an impact, or the end.

The kernels say it themselves: they are called on both sides of the instant, at one state.

Whether the force along a scalar s gives an impulse where s jumps with a moving place.

While s goes by Δs in a time ε its rate is Δs/ε, and the impulse is about ε f(Δs/ε): that of a
damper stays as ε vanishes, that of a force with a bound does not.
"""

from collections.abc import Callable, Iterator
from itertools import chain, islice, zip_longest

import numpy as np

from runtime.core.arrays import Integers, Vector
from runtime.core.kinds import SLIDING, Direction
from runtime.core.outcomes import Outcome
from runtime.explicit_time.function_scan import FAR, GROWTH, FunctionArrays
from runtime.explicit_time.instants import Kink, TimeInstants, time_instants
from runtime.integrate.problem import Passage, Stops
from runtime.mechanism.dense_equations import Equations, approaches
from runtime.mechanism.table_rows import MASS_LAW, TimeFunction

_FAST, _FASTER = 1e3, 1e12  # safety: of sizes and speeds; rates at which a force is judged
_GROWS = 1e-2  # safety: ratio of f/ṡ at these; it is 1 for f ~ ṡ, and 3e-5 for a root of ṡ
_SLOPE = 1e-6  # accuracy: of the size; difference of coordinates by which s_q is found
_NONE = 1e-300  # safety: least divisor, so that none is zero
_MOVED = 1e-9  # accuracy: of the size; a smaller jump of s has no direction


def acts(place: TimeFunction, kink: Kink, q: Vector, v: Vector, p: Vector, size: float) -> bool:
    """Whether an impulse comes where `place` jumps at `kink` in the state (q, v), (n,) each.

    `p` are the parameters, `size` is the largest typical size of a coordinate.
    """
    n, fastest = len(q), size + float(np.abs(v).max(initial=0.0))
    begin = {"q": len(p), "v": len(p) + n}
    for rows in place.along:
        scalar, force = (FunctionArrays(one, begin=begin) for one in rows)

        def s(t: float, q: Vector, of: FunctionArrays = scalar) -> float:
            return of.value(t, np.concatenate([p, q, v, [0.0]]))

        moved = s(kink.after, q) - s(kink.before, q)
        ways = (np.sign(moved),) if abs(moved) > _MOVED * size else (-1.0, 1.0)
        for t in (kink.before, kink.after):
            slopes = _slopes(s, t, q, _SLOPE * size)
            # what p, q, v and the rate are, and how they change with the rate
            here = np.concatenate([p, q, v, [slopes @ v]])
            toward = np.zeros(len(here))
            toward[begin["v"] :] = *(slopes / max(float(slopes @ slopes), _NONE)), 1.0
            if any(_grows(force, t, here, way * fastest * toward) for way in ways):
                return True
    return False


def _slopes(s: Callable[[float, Vector], float], t: float, q: Vector, step: float) -> Vector:
    """s_q, (n,), by central differences."""
    ways = step * np.eye(len(q))
    return np.array([(s(t, q + way) - s(t, q - way)) / (2.0 * step) for way in ways])


def _grows(force: FunctionArrays, t: float, here: Vector, way: Vector) -> bool:
    """Whether a force grows as its rate does, or faster, towards where `way` leads."""
    rest = force.value(t, here)
    near, far = (abs(force.value(t, here + k * way) - rest) / k for k in (_FAST, _FASTER))
    return not np.isfinite(far) or far > _GROWS * near


_GREAT = 1e3  # safety: of its size; the value at a pole is larger
_RATE_GROWTH = 3.0  # safety: as GROWTH, for ν; the rate of a root has 30, that of |t - a|^(2/3) 10
_ADVICE = (
    ": look for a table evaluated beyond its ends, a division by zero, or a root or logarithm of "
    "what is not positive"
)
_JUMP = 1e-9  # accuracy: of the typical size; a smaller jump is rounding
_WIDER = 5.0  # safety: distances of a kink's sides; a jump is as large between places that far


class Passages:
    """The kinks of a machine's explicit functions of time from t0 to t1, and how to pass them."""

    def __init__(self, equations: Equations, t0: float, t1: float, sizes: Vector) -> None:
        self.equations, self.span = equations, (t0, t1)
        self.size = float(sizes.max(initial=1.0))
        self.begun = self._parts()  # for one run; others find all parts but the first anew
        self.first = next(self.begun, None)  # often the only one

    def _parts(self) -> Iterator[TimeInstants]:
        return time_instants(self.equations.description, self.equations.p, *self.span)

    def parts(self) -> Iterator[TimeInstants]:
        """The instants, part by part."""
        if self.first is None or self.first.end >= self.span[1]:
            return iter([self.first] if self.first else [])
        begun, self.begun = self.begun, islice(self._parts(), 1, None)
        return chain([self.first], begun)

    def stops(self, parts: Iterator[TimeInstants] | None = None) -> Stops | None:
        """The instants at which the steps of a run end, of the next of `parts`."""
        parts = self.parts() if parts is None else parts
        part = next(parts, None)
        if part is None:
            return None
        bounds, kinks, end, crowd = part
        count, more = len(kinks), end < self.span[1]
        rows = [(float(t), -1, float(t)) for t in bounds]
        rows += [(kink.before, k, kink.after) for k, kink in enumerate(kinks)]
        steep = [(kink.steep, k) for k, kink in enumerate(kinks) if kink.steep is not None]
        rows += [(t, count + 1 + k, t) for t, k in steep]
        if crowd is not None:
            rows.append((crowd[0], count, crowd[0]))
        rows.sort()
        if more:
            last = max(end, rows[-1][2]) if rows else end
            rows.append((last, 2 * count + 1, last))
        if not rows:
            return None
        times, numbers, after = zip(*rows, strict=True)

        def passage(number: int, q: Vector, v: Vector, modes: Integers) -> Passage:
            if number == count:
                return self.crowded(part)
            if number > count:
                return self.steep(kinks[number - count - 1], q, v, modes)
            return self.passage(kinks[number], q, v, modes)

        arrays = np.array(times), np.array(numbers, np.int64), np.array(after)
        return Stops(*arrays, passage, (lambda: self.stops(parts)) if more else None)

    def agrees_until(self, other: "Passages") -> float:
        """The first instant, s, at which a step ends in runs to the end of one of both alone."""
        for ours, theirs in zip_longest(self._ends(), other._ends(), fillvalue=(np.inf, np.inf)):
            if ours != theirs:
                return min(ours[0], theirs[0])
        return np.inf

    def _ends(self) -> Iterator[tuple[float, float]]:
        """Where steps end, and where the next ones begin, s."""
        stops = self.stops()
        while stops is not None:
            yield from zip(stops.times.tolist(), stops.after.tolist(), strict=True)
            stops = None if stops.further is None else stops.further()

    def passage(self, kink: Kink, q: Vector, v: Vector, modes: Integers) -> Passage:
        """How a motion passes a kink in the state (q, v), (n,) each, under `modes`."""
        here = Passage(source=kink.function, function=self._name(kink.function))
        slides = bool(np.any(modes == SLIDING))
        if ended := self._while_closed(kink, q, v, modes):
            return ended
        modes = np.where(modes == SLIDING, 0, modes)
        sides = [self._values(t, q, v, modes) for t in kink[:2]]
        if kink.before <= self.span[0] and not all(np.isfinite(x).all() for x in sides[0]):
            return Passage()  # the run begins where a function has no value: others say so
        if ended := self._without_bound(kink, sides, q, v, modes):
            return ended
        for number, jump in kink.jumps:
            place = self.equations.description.time_functions[number]
            least = _JUMP * self.size
            if jump > least and acts(place, kink, q, v, self.equations.p, self.size):
                what = f"jumps by {jump:.6g} at t = {kink.after:.9g} s, where its rate acts"
                return self._end(kink._replace(function=number), what, -1)
        (phi, nu, gamma, *_), (phi_after, nu_after, gamma_after, *_) = sides
        apart, most = kink.after - kink.before, np.maximum
        jumps = np.abs(phi_after - phi) - 2.0 * apart * most(np.abs(nu), np.abs(nu_after))
        if np.any(jumps > _JUMP * self.size):
            row = int(jumps.argmax())
            size = abs(float(phi_after[row] - phi[row]))
            return self._end(kink, f"jumps by {size:.6g} at t = {kink.after:.9g} s", row)
        speeds = most(np.abs(nu), np.abs(nu_after))
        jumps = np.abs(nu_after - nu) - 2.0 * apart * most(np.abs(gamma), np.abs(gamma_after))
        jumps -= _JUMP * most(speeds, self.size)
        if np.any(jumps > 0.0):
            row = int(jumps.argmax())
            size = abs(float(nu_after[row] - nu[row]))
            kinds = [one.kind for one in self.equations.description.constraints]
            strikes = any(k != MASS_LAW for k, jump in zip(kinds, jumps, strict=True) if jump > 0.0)
            if slides and strikes:
                text = f"has a rate that jumps by {size:.6g} a second at t = {kink.after:.9g} s, "
                holds = "while a contact is closed, friction sticks or a one-way clutch grips"
                return self._end(kink, f"{text}{holds}", row)
            v_after, _ = self.equations.impact(kink.after, q, v)

            def behind(t: float) -> bool:
                rate = float(self.equations.velocity_rhs(t, q)[row])
                return bool(abs(rate - nu_after[row]) < abs(rate - nu[row]))

            event = Direction.IMPACT if strikes else Direction.BEGAN
            return here._replace(v=v_after, behind=behind, event=event)
        before, after = (np.concatenate(values[2:]) for values in sides)
        bends = not np.allclose(before, after, rtol=_JUMP, atol=_JUMP)
        if bends:  # or both are steep alone
            instants = kink.before - _WIDER * apart, kink.after + _WIDER * apart
            left, right = (np.concatenate(self._values(t, q, v, modes)[2:]) for t in instants)
            most_steep = np.maximum(_JUMP * (1.0 + np.abs(after)), 0.5 * np.abs(right - left))
            bends = not np.all(np.abs(after - before) <= most_steep)
        return here._replace(event=Direction.BEGAN if bends else None)

    def _while_closed(self, kink: Kink, q: Vector, v: Vector, modes: Integers) -> Passage | None:
        """The end of a run where the rate of a gap or of a freewheel jumps while it is closed."""
        system = self.equations.mechanism.system
        closed = [k for k in (*system.rigid, *system.one_way) if modes[k] == SLIDING]
        if not closed:
            return None
        before, after = (approaches(self.equations, t, q, v)[closed] for t in kink[:2])
        jumps = np.abs(after - before)
        if not jumps.max() > _JUMP * max(self.size, float(np.abs(v).max(initial=0.0))):
            return None
        name = self.equations.description.switches[closed[int(jumps.argmax())]].name
        text = f"has a rate that jumps by {jumps.max():.6g} a second at t = {kink.after:.9g} s, "
        return self._end(kink, f"{text}while '{name}' is closed or grips", -1)

    def first_instant(self, q: Vector, v: Vector) -> float:
        """The first instant, s; where an impact of a law would strike (q, v) there, behind it."""
        kinks, t0 = self.first.kinks if self.first else (), self.span[0]
        if not kinks or kinks[0].before > t0:
            return t0
        modes = np.zeros(len(self.equations.description.switches), np.int64)
        struck = self.passage(kinks[0], q, v, modes).event is Direction.IMPACT
        return kinks[0].after if struck else t0

    def steep(self, kink: Kink, q: Vector, v: Vector, modes: Integers) -> Passage:
        """The end of a run where a function begins to grow without bound, if that acts at all.

        State and modes go on to change until then. It acts at whatever speed, and in all modes.
        """
        moving = q + self.size, v + self.size
        states = [
            (*state, m) for state in ((q, v), moving) for m in (modes, 0 * modes, 0 * modes + 1)
        ]
        ends = []
        for there_q, there_v, m in states:
            there = np.where(m == SLIDING, 0, m)
            sides = [self._values(t, there_q, there_v, there) for t in kink[:2]]
            ends.append(self._without_bound(kink, sides, there_q, there_v, there))
        for k in range(2):
            found = ends[3 * k : 3 * k + 3]
            if found[0] is not None and None not in found:
                return found[0]
        return Passage()

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
        far = FAR * 0.5 * (kink.after - kink.before)
        for side, way in zip(sides, (-far, far), strict=True):
            there = self._values(0.5 * (kink.before + kink.after) + way, q, v, modes)
            for order, (near, distant) in enumerate(zip(side, there, strict=True)):
                growth = _RATE_GROWTH if order == 1 else GROWTH
                grown = np.abs(near) > np.maximum(growth * np.abs(distant), _GREAT * self.size)
                bad = ~np.isfinite(near) | (
                    (order != 2) & grown
                )  # γ may grow, but not its integral
                if bad.any():
                    row = int(bad.argmax()) if order < 3 else -1
                    text = f"has no finite {'rate' if order in (1, 2) else 'value'}"
                    text += f" at t = {kink.after:.9g} s{_ADVICE}"
                    return self._end(kink, text, row)
        return None

    def _end(self, kink: Kink, what: str, row: int) -> Passage:
        return Passage(
            Outcome.DISCONTINUOUS,
            row,
            f"A function of time in '{self._name(kink.function)}' {what}.",
        )

    def crowded(self, part: TimeInstants) -> Passage:
        """The end of a run where changes of a function accumulate."""
        assert part.crowd is not None
        begin, end, function = part.crowd
        note = (
            f"A function of time in '{self._name(function)}' changes ever faster up to about "
            f"t = {end:.9g} s, infinitely often; from t = {begin:.9g} s on its changes cannot be "
            "told apart. Write one whose changes come to rest, such as a frequency with a bound in "
            "place of 1/(t - a), or end the run before this time."
        )
        return Passage(Outcome.ZENO, note=note)

    def _name(self, function: int) -> str:
        return self.equations.description.time_functions[function].name
