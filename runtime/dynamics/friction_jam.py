"""Friction that jams where a run ended: no acceleration agrees with sliding (P. Painlevé)."""

from dataclasses import replace

import numpy as np

from runtime.core.modes_and_event_kinds import SLIDING
from runtime.core.outcomes import Outcome
from runtime.integrate.trajectory import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism

# What a run meets first on its way into a jam, where the multipliers grow without bound.
_WAYS_IN = {
    Outcome.SINGULAR, Outcome.CONTRADICTED, Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED,
    Outcome.NOT_FINITE,
}  # fmt: skip
_CLOSE = 1e-6  # safety: of the run; nearer to a jam, the jam is why it ends
_JAM = (
    "{} jams{}: friction raises the force that presses{} by more than it needs, and no "
    "acceleration agrees with sliding on. A creep speed does not help: lower the coefficient, "
    "start at rest, where friction may stick, or replace the joint by a contact that can open."
)


def end_at_jam(mechanism: Mechanism, run: Trajectory, p: FloatArray, duration: float) -> Trajectory:
    """The run, ended by the jam of a friction with a creep speed, where one is as near as that.

    `duration`, s, is that of the whole run. Where the motion goes on, its accelerations are no
    numbers then, and the kernel names the joint. At rest such a friction has no force: where the
    accelerations are no numbers then either, it is not what ends the run.
    """
    rubs = any(row.kind == "friction" for row in mechanism.description.effects)
    named = run.outcome is not Outcome.SINGULAR and run.index >= 0
    if run.outcome not in _WAYS_IN or named or not rubs:
        return run
    equations, (t, q, v) = Equations(mechanism, p), (run.final_t, run.final_q, run.final_v)
    a, _, _ = equations.motion(t, q, v, run.final_modes)
    a = np.where(np.isfinite(a), a, 0.0)
    for h in _CLOSE * duration * np.array([0.0, 0.001, 0.01, 0.1, 1.0]):
        there = t + h, q + h * (v + 0.5 * h * a), v + h * a
        ahead, _, weak = equations.motion(*there, run.final_modes)
        if weak > 0 and not np.isfinite(ahead).all():
            resting, _, _ = equations.motion(there[0], there[1], np.zeros_like(v), run.final_modes)
            if not np.isfinite(resting).all():
                return run
            return replace(run, outcome=Outcome.NOT_FINITE, index=weak - 1)
    return run


def describe_jam(mechanism: Mechanism, run: Trajectory, p: FloatArray) -> str:
    """Sentences on the friction whose jam ended a run; empty where none did.

    A friction with a creep speed jams in a joint that `run.index` names by its constraint; one
    that sticks is a switching function, whose slip tells to which side it slides.
    """
    description, k = mechanism.description, run.index
    if run.outcome is Outcome.NOT_FINITE and k >= 0:
        names = [row.name for row in description.effects if row.kind == "friction"]
        name = f" {names[0]}" if len(names) == 1 else ""
        return _JAM.format(f"Friction{name} in joint {description.constraints[k].element}", "", "")
    place = dict(mechanism.system.stiction).get(k)
    if run.outcome is not Outcome.INCONSISTENT or place is None:
        return ""
    equations, state = Equations(mechanism, p.copy()), (run.final_t, run.final_q, run.final_v)
    g = equations.switching(*state)
    modes = np.where(run.final_modes == SLIDING, g > 0.0, run.final_modes).astype(np.int64)
    modes[k] = g[k] > 0.0
    a, _, weak = equations.motion(*state, modes)
    equations.p[place], modes[k] = 0.0, SLIDING
    free, multipliers, _ = equations.motion(*state, modes)
    if np.isfinite(a).all() or not np.isfinite(free).all():
        return ""
    joint = f" in joint {description.constraints[weak - 1].element}" if weak > 0 else ""
    speed, raised = f" at a slip of {g[k]:.3g}", ""
    rows = {row: limit for row, _, limit in description.friction_limits}
    if k in rows:
        unit = description.reactions[rows[k]].unit
        speed += " rad/s" if unit == "N m" else " m/s"
        before = equations.reactions(*state, multipliers, modes)[rows[k]]
        equations.p[place] = -np.copysign(1.0, g[k])
        _, multipliers, _ = equations.motion(*state, modes)
        more = equations.reactions(*state, multipliers, modes)[rows[k]] - before
        if more > 1.0:
            raised = f" (1 {unit} of friction its limit by {more:.3g} {unit})"
    return _JAM.format(f"Friction {description.switches[k].name}{joint}", speed, raised)
