"""Friction that jams where a run ended: no acceleration agrees with sliding (P. Painlevé).

And machines that lock up because friction sticks or a rigid contact is closed: what these keep as
it is and the joints are no longer independent, so that all forces grow without bound, and with them
that which friction may exert.
"""

import numpy as np
import numpy.typing as npt

from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome, Site
from runtime.dynamics.output_quantities import evaluate
from runtime.integrate.problem import Trajectory
from runtime.mechanism.dense_equations import (
    Equations,
    FloatArray,
    IntArray,
    approaches,
    rate_rows,
    row_lengths,
)
from runtime.mechanism.module_tables import Description

# What a run meets first on its way into a jam, where the multipliers grow without bound.
_WAYS_IN = {
    Outcome.SINGULAR, Outcome.CONTRADICTED, Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED,
    Outcome.NOT_FINITE,
}  # fmt: skip
# What it may meet at events before a lock-up, where a contact's response to its force is rounding.
_OF_ROUNDING = {Outcome.INCONSISTENT, Outcome.ZENO, Outcome.CONTRADICTED}
_CLOSE = 1e-6  # safety: of the run; a jam that is nearer to the end is its cause
_AHEAD = np.array([0.0, 0.001, 0.01, 0.1, 1.0])  # safety: of `_CLOSE`; instants that are tried
_LOST = 1e-3  # safety: largest least singular value, in unit rows, of a lock-up
_OWN = 0.1  # safety: of that of the joints alone; with more they are singular themselves
_TOUCHING = 1e-9  # accuracy: of the machine's size; a narrower gap is closed
_BEYOND = 1e-6  # safety: drivers' speed over the speed needed to follow them; less is a lock-up
_JAM = (
    "{} jams{}: friction raises the force that presses{} by more than it needs, and no "
    "acceleration agrees with sliding on. A creep speed does not help: lower the coefficient, "
    "start at rest, where friction may stick, or replace the joint by a contact that can open."
)
_BESIDE = (
    "{} slides and {} still, and no forces were found that do both: friction jams where it raises "
    "the force that presses by more than it needs, or is about to. Lower the coefficient, or give "
    "creep= to a friction that sticks, stiffness= to a contact that is closed."
)
_LOCKED = (
    "What {} as it is and the joints and drivers are no longer independent there: forces grow "
    "without bound{}. Give the friction creep= or the contact stiffness=, or lower a coefficient."
)


def end_at_jam(equations: Equations, run: Trajectory, duration: float) -> Trajectory:
    """The run, ended by a lock-up or the jam of a friction, where one is as near as that.

    `duration`, s, is that of the whole run. Where the motion goes on, its accelerations are no
    numbers then, and the kernel names the joint of a friction with a creep speed. At rest such a
    friction has no force: where the accelerations are no numbers then either, it is not what ends
    the run.
    """
    description, system = equations.description, equations.mechanism.system
    rubs = any(row.kind == "friction" for row in description.effects)
    named = run.outcome is not Outcome.SINGULAR and run.index >= 0
    grows = run.outcome in _WAYS_IN and not named
    if not (grows or run.outcome in _OF_ROUNDING):
        return run
    if not (rubs or description.rigid or system.one_way):
        return run
    t, q, v = run.end
    locked = grows and _describe_lock_up(equations, run, proven=False)
    locked = locked or _describe_lock_up(equations, run, proven=True)
    if locked:
        ended = Outcome.LOCKED if description.drivers else Outcome.SINGULAR
        return run._replace(outcome=ended, site=Site.JAM, index=-1, note=locked)
    if not grows:
        return run
    a, _, _ = equations.motion(t, q, v, run.final_modes)
    a = np.where(np.isfinite(a), a, 0.0)
    with np.errstate(over="ignore", invalid="ignore"):  # of a run of 1e300 s
        later = [(t + h, q + h * (v + 0.5 * h * a), v + h * a) for h in _CLOSE * duration * _AHEAD]
    for there in later:
        ahead, _, weak = equations.motion(*there, run.final_modes)
        if weak > 0 and not np.isfinite(ahead).all():
            resting, _, _ = equations.motion(there[0], there[1], np.zeros_like(v), run.final_modes)
            if np.isfinite(resting).all():
                return run._replace(outcome=Outcome.NOT_FINITE, site=Site.JAM, index=weak - 1)
            break
    sentences = (_describe_switched(equations, there, run.final_modes) for there in later)
    jammed = next(filter(None, sentences), "")
    if not jammed:
        return run
    return run._replace(outcome=Outcome.NOT_FINITE, site=Site.JAM, index=-1, note=jammed)


def _describe_lock_up(equations: Equations, run: Trajectory, *, proven: bool) -> str:
    """Sentences where friction that sticks, and contacts, lock the machine up; empty otherwise.

    If `proven`, drivers must ask for velocities that nothing permits. A contact that touches may
    then be open: it bounces, and the last bounces are rounding.
    """
    system, switches = equations.mechanism.system, equations.description.switches
    t, q, closed = run.final_t, run.final_q, run.final_modes == SLIDING
    size = equations.size(t, q)
    if proven:
        rigid = list(system.rigid)
        gaps = equations.switching(t, q, run.final_v)[rigid]
        closed[rigid] |= np.abs(gaps) <= _TOUCHING * size
    kept = [k for k in sorted((*system.sticking, *system.rigid, *system.one_way)) if closed[k]]
    if not kept:
        return ""
    scale = equations.scale(size)
    joints = (equations.jacobian(t, q) * scale)[equations.independent]
    both = np.vstack([joints, rate_rows(equations, t, q)[kept] * scale])
    if not np.isfinite(both).all():
        return ""
    lengths = row_lengths(both)
    unit = both / lengths[:, None]
    alone = _least(joints / row_lengths(joints)[:, None])
    if not 0.0 < _least(unit) < min(_LOST, _OWN * alone):
        return ""
    if proven:
        rates = approaches(equations, t, q, np.zeros(equations.n))[kept]
        moved = np.append(equations.velocity_rhs(t, q)[equations.independent], -rates)
        one_sided = np.array([k not in system.sticking for k in kept])
        blocks = blocking_rows(unit, moved / lengths, one_sided)
        kept = [k for k, part in zip(kept, blocks, strict=True) if part]
        if not kept:
            return ""
    rubs = [switches[k].name for k in kept if k in system.sticking]
    shut = [switches[k].name for k in kept if k in system.rigid]
    words = [f"friction {name}" for name in rubs] + [f"contact or stop {name}" for name in shut]
    words += [f"one-way clutch {switches[k].name}" for k in kept if k in system.one_way]
    grows = ", and what friction may exert grows with them" if rubs else ""
    return _LOCKED.format(f"{' and '.join(words)} keep{'s' if len(words) == 1 else ''}", grows)


def blocking_rows(
    rows: FloatArray, moved: FloatArray, one_sided: npt.NDArray[np.bool_]
) -> npt.NDArray[np.bool_]:
    """Which of what is kept, (k,), forbids all w with rows w = moved; none where such w exist.

    The last k rows are those of what is kept; of `one_sided` ones rows w may be more than moved.
    With the left vector u of the least singular value σ such a w is at least (uᵀ moved)/σ, and
    where u has no negative entry for a one-sided row, no such row relieves it (J. Farkas).
    """
    left, values, _ = np.linalg.svd(rows, full_matrices=False)
    u = left[:, -1] * np.sign(left[:, -1] @ moved)
    parts, least = u[-len(one_sided) :], _OWN * np.abs(u).max()
    beyond = values[-1] * np.linalg.norm(moved) < _BEYOND * (u @ moved)
    relieved = bool((parts[one_sided] < -least).any())
    forbids: npt.NDArray[np.bool_] = (np.abs(parts) > least) & (beyond and not relieved)
    return forbids


def _least(rows: FloatArray) -> float:
    """The least singular value of rows of length 1; 0 of more rows than columns."""
    if len(rows) > rows.shape[1]:
        return 0.0
    return float(np.linalg.svd(rows, compute_uv=False).min(initial=1.0))


def _describe_switched(
    equations: Equations, state: tuple[float, FloatArray, FloatArray], modes: IntArray
) -> str:
    """Sentences on frictions that slide and jam, maybe beside what sticks; empty otherwise.

    The accelerations of a jam exist as soon as what jams is kept as it slides.
    """
    t, q, v = state

    def exist(modes: IntArray, v: FloatArray = v) -> bool:
        found = evaluate(equations, np.array([t]), q[None], v[None], modes[None])
        return bool(np.isfinite(found.a).all())

    description, stiction = equations.description, equations.mechanism.system.stiction
    if exist(modes):
        return ""
    slides = [k for k, _ in stiction if modes[k] != SLIDING]
    trials = [[k] for k in slides] + ([slides] if len(slides) > 1 else [])
    names: list[str] = []
    for trial in trials:
        if exist(np.where(np.isin(np.arange(len(modes)), trial), SLIDING, modes)):
            names = [description.switches[k].name for k in trial]
            break
    creeping = _creeping(description)
    if not names and creeping and exist(modes, np.zeros_like(v)):
        names = creeping
    if not names:
        return ""
    kept = [description.switches[k].name for k in np.flatnonzero(modes == SLIDING)]
    rubs = f"Friction {' or '.join(names)}"
    if kept:
        return _BESIDE.format(rubs, f"{' and '.join(kept)} keep{'s' if len(kept) == 1 else ''}")
    return _JAM.format(rubs, "", "")


def _creeping(description: Description) -> list[str]:
    """Names of frictions with a creep speed, which have no switch."""
    switched = {row.name for row in description.switches}
    rows = [row.name for row in description.effects if row.kind == "friction"]
    return [name for name in rows if name not in switched]


def describe_jam(equations: Equations, run: Trajectory) -> str:
    """Sentences on the friction whose jam ended a run; empty where none did.

    A friction with a creep speed jams in a joint that `run.index` names by its constraint; one
    that sticks is a switching function, whose slip tells to which side it slides.
    """
    description, mechanism, k = equations.description, equations.mechanism, run.index
    if run.outcome is Outcome.NOT_FINITE and k < 0:
        return run.note
    if run.outcome is Outcome.NOT_FINITE and k >= 0:
        names = _creeping(description)
        name = f" {names[0]}" if len(names) == 1 else ""
        return _JAM.format(f"Friction{name} in joint {description.constraints[k].element}", "", "")
    place = dict(mechanism.system.stiction).get(k)
    if run.outcome is not Outcome.INCONSISTENT or place is None:
        return ""
    equations, state = Equations(mechanism, equations.p.copy()), run.end
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
