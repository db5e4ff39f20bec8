"""Simulations in which joints come and go: one run after the other, each with those that act.

Every set of joints is a scene of its own, with its own module, coordinates and partition. A run
ends where a joint is released or engages, and the next begins there.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.joined_results import joined
from runtime.dynamics.reconnection import Gap, carried, cross, known_parameters
from runtime.dynamics.simulation import simulate as simulate_once
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.sibling_scenes import sibling
from runtime.results.assembled_state import Assembly, State
from runtime.results.reconnection import Reconnection
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.validation.output_instants import uniform

_MOST = 10_000  # safety: changes of joints in a run
_AT_ONCE = 16  # safety: changes of joints at one instant


def simulate(mechanism: Mechanism, t_end: float, t_eval: Any = None, **settings: Any) -> Result:
    """Integrate the equations of motion, with other joints from where these come or go."""
    if not any(row.reconnects for row in mechanism.description.watched):
        return simulate_once(mechanism, t_end, t_eval, **settings)
    start = settings.get("start")
    first = start.t if isinstance(start, Assembly | State) else settings.get("t_start", 0.0)
    if (t_eval is None or isinstance(t_eval, int)) and first <= t_end:
        t_eval = uniform(first, t_end, t_eval)
    parameters = dict(settings.pop("parameters", None) or {})
    results, changes, at_once = list[Result](), list[Reconnection](), 0
    while True:
        values = known_parameters(mechanism, parameters) if changes else parameters
        instants, none_left = _later(t_eval, changes, t_end)
        run = simulate_once(mechanism, t_end, instants, parameters=values, **settings)
        if none_left and run.outcome is Outcome.OK:
            run.samples = Samples._make(array[:0] for array in run.samples)
            run.works = {name: work[:0] for name, work in run.works.items()}
        if changes:
            run.message = run.message.partition(" It starts from a state")[0]
        results.append(run)
        if run.reconnection is None or run.outcome is not Outcome.OK:
            break
        row, end, memory = run.reconnection
        at_once = at_once + 1 if changes and changes[-1].t == end.t else 0
        if end.t >= t_end:
            break
        if at_once > _AT_ONCE or len(changes) >= _MOST:
            run.outcome, run.message = Outcome.ZENO, _endless(changes)
            break
        watched = mechanism.description.watched[row]
        after = sibling(mechanism, watched)
        try:
            begin, change = cross(mechanism, after, watched, end, parameters)
        except Gap as gap:
            run.outcome, run.message = Outcome.INCONSISTENT, str(gap)
            break
        changes.append(change)
        settings |= {"start": begin, "guess": None, "t_start": 0.0}
        settings["memory"] = carried(mechanism, after, memory)
        mechanism = after
    return results[0] if len(results) == 1 else joined(results, changes)


def _later(t_eval: Any, changes: list[Reconnection], t_end: float) -> tuple[Any, bool]:
    """The instants behind the last change, s, and whether there are none but the end."""
    if not changes or not isinstance(t_eval, np.ndarray | list | tuple):
        return t_eval, False
    times: npt.NDArray[np.float64] = np.asarray(t_eval, dtype=np.float64)
    later = times[times > changes[-1].t]
    return (later, False) if len(later) else (np.array([t_end]), True)


def _endless(changes: list[Reconnection]) -> str:
    last = changes[-1]
    return (
        f"Stopped at t = {last.t:.9g} s. Joints come and go without end, the last '{last.joint}' "
        f"({len(changes)} changes): the condition under which it is released holds where it "
        "engages. Give conditions that do not hold at the same time."
    )
