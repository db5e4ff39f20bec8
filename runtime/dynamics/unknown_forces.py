"""Effects that exert what drivers would: their values at the prescribed motion.

The multipliers λ_d of the drivers follow from the values u of the effects, λ_d = λ_d0 + L u, and
vanish where u is what the effects must exert. By virtual work, L has the rates of the lengths and
angles of the effects by those that are driven. Friction in joints bends the line, so that Newton's
method goes on from there. Of more effects than drivers the values are those with the least sum of
(weight times value)², among neighbours where the line bends or has a kink, N = 0. The weights stand
in `p` where the kernels take the values.
"""

from collections.abc import Mapping
from copy import copy
from functools import cached_property
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError
from codegen.object_display import counted, listed
from runtime.core.arrays import EPS
from runtime.dynamics.output_quantities import evaluate_rows
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Numbers, seeking
from runtime.mechanism.table_rows import unknown as missing
from runtime.results.result import Result
from runtime.results.samples import Samples, empty_samples

_MOST = 100  # safety: evaluations at an instant, of which friction asks for more than three
_REACHED = 1e-9  # accuracy: of the drivers' multipliers without the effects; what may be left
_ROUNDED = 64.0  # accuracy: of the rounding of the largest multiplier; what may be left
_CHANGE = 1e-6  # accuracy: of the size of multipliers, by which friction is linearized
_SHARE = 1e-6  # accuracy: of a dependency; an effect with less has no part in it
_SHOWN = 5  # layout: instants that a message names


class Transmission:
    """L at k instants, of whose samples states and modes are known."""

    def __init__(self, equations: Equations, states: Samples) -> None:
        self.equations, self.states = equations, states
        description, self.names = equations.description, equations.description.unknown
        self.slots = [description.parameters.index(name) for name in self.names]
        self.weights = equations.p[self.slots]
        self.drivers = np.flatnonzero(description.driver_rows)
        self.bent = any(row.kind == "friction" for row in description.effects)
        none = np.zeros(len(self.names))
        self.given = self._exerted(states, none)  # where all values are zero
        self.without = self.given.lam[:, self.drivers]  # λ_d0, (k, d)
        self.slopes = self._slopes(self.given, none)  # (k, d, u)

    @cached_property
    def rank(self) -> npt.NDArray[np.int64]:
        """Rank of L, (k,), in units in which the machine's length is 1; 0 where it is no number."""
        t, q, rows = float(self.states.t[0]), self.states.q[0], self.equations.description.reactions
        length = self.equations.size(t, q)
        units = {row.element: row.unit for row in rows if "N" in row.unit}
        arms = [1.0 if units.get(name) == "N m" else length for name in self.names]
        scaled = self.slopes * self.equations.row_scale(t, q, length)[self.drivers, None] / arms
        values = np.linalg.svd(np.nan_to_num(scaled, posinf=0.0, neginf=0.0), compute_uv=False)
        return np.asarray((values > NO_PIVOT).sum(axis=1))

    def write_samples(self, samples: Samples) -> None:
        """Write what follows from the states; no numbers where no values, or any, would do."""
        for k, (without, slopes) in enumerate(zip(self.without, self.slopes, strict=True)):
            row, values = samples.at(slice(k, k + 1)), np.full(len(self.names), np.nan)
            if self.rank[k] == len(without):
                values = self._solved(row, -self._inverse(slopes) @ without, slopes, without)
                if self.bent and len(values) > len(without):
                    values = self._least(row, values, without)
            if self.bent or np.isnan(values).any():
                evaluate_rows(self._with(values), row)
        samples.a[:] = self.given.a

    def _solved(self, row: Samples, u: FloatArray, slopes: FloatArray, given: Any) -> FloatArray:
        """Values near these with which drivers exert nothing, else no numbers; writes the row."""
        inverse, before = self._inverse(slopes), np.inf
        for _ in range(_MOST):
            evaluate_rows(self._with(u), row)
            sizes = np.nan_to_num(np.abs(row.lam[0]), posinf=0.0)
            left, rounding = np.abs(row.lam[0, self.drivers]).max(), EPS * sizes.max()
            permitted = _REACHED * np.abs(given).max() + _ROUNDED * rounding
            if not left > rounding or before <= left <= permitted:
                break
            if self.bent:
                inverse = self._inverse(self._slopes(row, u)[0])
            u, before = u - inverse @ row.lam[0, self.drivers], left
        return u if left <= permitted else np.nan * u

    def _least(self, row: Samples, values: FloatArray, without: FloatArray) -> FloatArray:
        """From values on to those of least norm, by steps that shorten where friction bends."""
        step, norm = 1.0, float(np.linalg.norm(self.weights * values))
        for _ in range(_MOST):
            evaluate_rows(self._with(values), row)
            slopes = self._slopes(row, values)[0]
            way = step * (self._inverse(slopes) @ slopes @ values - values)
            if not np.linalg.norm(self.weights * way) > _REACHED * norm:
                break
            found = self._solved(row, values + way, slopes, without)
            shorter, step = float(np.linalg.norm(self.weights * found)), step / 2.0
            if shorter < norm:
                values, norm, step = found, shorter, min(1.0, 4.0 * step)
        return values

    def _with(self, values: FloatArray) -> Equations:
        """The equations in which the effects have these values, (u,)."""
        found = copy(self.equations)
        found.p = found.p.copy()
        found.p[self.slots] = values
        found.kernels.constants(found.p)
        return found

    def _exerted(self, states: Samples, values: FloatArray) -> Samples:
        found = empty_samples(self.equations.description, len(states.t))
        found = found._replace(t=states.t, q=states.q, v=states.v, modes=states.modes)
        evaluate_rows(self._with(values), found)
        return found

    def _slopes(self, at: Samples, values: FloatArray) -> FloatArray:
        """L by differences from these samples, in which the effects have these values."""
        if self.bent and len(at.t) > 1:  # each on its own scale
            return np.concatenate([self._slopes(at.at([k]), values) for k in range(len(at.t))])
        size = float(np.nan_to_num(np.abs(at.lam), posinf=0.0).max(initial=0.0)) or 1.0
        change = (_CHANGE if self.bent else 1.0) * size
        changed = (self._exerted(at, values + one) for one in change * np.eye(len(values)))
        return np.stack([one.lam - at.lam for one in changed], axis=2)[:, self.drivers] / change

    def _inverse(self, slopes: FloatArray) -> FloatArray:
        """That of least norm, (u, d)."""
        scaled = np.linalg.pinv(np.nan_to_num(slopes) / self.weights, rcond=EPS)
        return np.asarray(scaled / self.weights[:, None])


def variant_with_unknown(
    mechanism: Mechanism, unknown: tuple[str, ...], weights: Mapping[str, Any]
) -> tuple[Mechanism, Numbers]:
    """The mechanism in which the effects exert what drivers would, and the weights of all."""
    title, names, rows = mechanism.title, tuple(dict.fromkeys(unknown)), mechanism.description
    driven = [rows.constraints[k].name for k in np.flatnonzero(rows.driver_rows)]
    if not 0 < len(driven) <= len(names):
        raise InputError(
            f"{title}: unknown is {listed(names)} for {counted(len(driven), 'driven coordinate')}"
            f" ({listed(driven)}). Name as many effects, or leave drivers out."
        )
    for name, value in weights.items():
        if name not in names:
            raise InputError(f"{title}: weights: {missing('unknown', name, names)}")
        if not (isinstance(value, float) and 0.0 < value < np.inf):
            raise InputError(f"{title}: the weight of {name} is {value!r}; give a positive number.")
    return seeking(mechanism, names), {**dict.fromkeys(names, 1.0), **weights}


def describe_unknown(result: Result) -> None:
    """Say whose values were sought and where there are none; AnalysisError where nowhere are."""
    found = Transmission(cast(Any, result._motion).equations, result.samples)
    names, count = listed(found.names), len(found.drivers)
    driven = listed(result.description.constraints[k].element for k in found.drivers)
    best = int(np.argmax(found.rank))
    if found.rank[best] < count and not result.failed:
        raise AnalysisError(
            f"{result.description.title}: drivers move {driven}, and {names} move "
            f"{found.rank[best]} of these {count}: {_fault(found, best)}. Name other effects."
        )
    message = f" Sought: {names}, in place of {driven}."
    if len(found.names) > count:
        each = (f"{n} {w:g}" for n, w in zip(found.names, found.weights, strict=True))
        message += (
            f" Unknowns are {len(found.names)} for {count} driven coordinates: the sum of (weight "
            f"times SI value)² is the least{' found' * found.bent}, with weights {listed(each)}."
        )
    lost = result.t[np.isnan(result.samples.lam[:, found.drivers]).any(axis=1)]
    if len(lost):
        where = ", ".join(f"{t:.6g}" for t in lost[:_SHOWN]) + ", ..." * (len(lost) > _SHOWN)
        message += (
            f" At {counted(len(lost), 'instant')} (t = {where} s) no values of them, or any, do "
            "what drivers would: what follows from them is not a number there."
        )
    result.message += message


def _fault(found: Transmission, best: int) -> str:
    """The effects that move nothing at an instant, or else those that depend on each other."""
    names, slopes = np.array(found.names), np.nan_to_num(found.slopes[best])
    if len(idle := names[np.abs(slopes).max(axis=0) <= NO_PIVOT]):
        return f"nothing that is driven moves by {listed(idle)}"
    dependent = np.linalg.svd(slopes)[2][found.rank[best] :]
    return f"{listed(names[np.abs(dependent).max(axis=0) > _SHARE])} depend on each other"
