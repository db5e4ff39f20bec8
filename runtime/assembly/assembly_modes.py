"""Assembly modes: all positions in which the joints close at one instant, from random starts.

From each start the joints are closed as those of any start are. After K modes in N starts that
close, with all shares of the modes as probable as each other, K (K + 1) / (N - K - 2) modes more
are to be expected (C. G. E. Boender and A. H. G. Rinnooy Kan, Bayesian stopping rules for
multistart global optimization methods, Mathematical Programming 37, 1987).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from codegen.errors import AnalysisError, UnknownNameError
from codegen.object_display import counted, listed, without_rounding
from runtime.assembly import regular_start
from runtime.assembly.assemble import assemble
from runtime.assembly.joint_closing import CLOSED, ROUGH, Task, refine
from runtime.assembly.mode_signs import distinguishing_signs
from runtime.assembly.start_values import Start, start_values
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Numbers
from runtime.mechanism.table_rows import unknown
from runtime.results.assembled_state import Assembly

_UNSEEN = 0.1  # accuracy: expected number of modes not met, at which a search ends
_LEAST = 100  # measured: starts that close, before that number says anything
_MOST, _HOPELESS = 20_000, 1_000  # safety: starts of a search; starts none of which closes
# accuracy: scaled distance of two positions that are one; of singular ones, known to its root
_SAME, _SAME_SINGULAR = 1e-6, 1e-4
_SINGULAR = 20  # safety: most singular positions; more of them belong to a motion
_TURN = 2.0 * np.pi


@dataclass(frozen=True, repr=False)
class AssemblyModes:
    """All modes of a machine at one instant: `modes[2]`, or `modes["+-+"]` by its label.

    A label has a character for each of `signs`. Of "A-B-C" it is "+" where the way from joint A to
    joint B turns left to joint C; of "det" it is the sign of the determinant of the constraints,
    opposite in two modes that are about to meet. Modes that no sign tells apart have one label, and
    differ by number. After so many `starts` of the search, `unseen` modes more are to be expected.
    """

    title: str
    modes: tuple[Assembly, ...]
    signs: tuple[str, ...]
    labels: tuple[str, ...]
    starts: int
    unseen: float

    def __len__(self) -> int:
        """Number of modes."""
        return len(self.modes)

    def __iter__(self) -> Iterator[Assembly]:
        """The modes in the order of their signs."""
        return iter(self.modes)

    def __getitem__(self, which: int | str) -> Assembly:
        """A mode by its number or by its label."""
        if isinstance(which, str) and self.labels.count(which) != 1:
            raise UnknownNameError(unknown("single mode", which, self.labels))
        return self.modes[self.labels.index(which) if isinstance(which, str) else which]

    def __repr__(self) -> str:
        """Their number, how sure it is, and a line for each mode with its label and angles."""
        table = self.modes[0].coordinates
        shown = [k for k, row in enumerate(table) if row.is_angle] or [*range(len(table))]
        lines = [
            f"{self.title}: {counted(len(self), 'assembly mode')} at t = {self.modes[0].t:g} s",
            f"From {self.starts} random starts; {self.unseen:.2g} more modes are to be expected.",
            f"signs: {listed(self.signs)}; values: {', '.join(table[k].name for k in shown)}",
        ]
        for number, (label, mode) in enumerate(zip(self.labels, self.modes, strict=True)):
            values = " ".join(f"{x:11.6g}" for x in without_rounding(mode.q[shown]))
            lines.append(f"{number:4} {label} {values}{'  modes meet' * bool(mode.singular)}")
        return "\n  ".join(lines)


def assembly_modes(equations: Equations, t: float, start_at: Numbers | None) -> AssemblyModes:
    """All modes at t, with the fixed start values of the scene and of `start_at` held."""
    start, task = _closure(equations, t, start_at)
    found, random, unseen = np.zeros((0, equations.n)), np.random.default_rng(1), np.inf
    starts = closed = singular = 0
    while starts < (_MOST if closed else _HOPELESS) and (closed < _LEAST or unseen > _UNSEEN):
        starts += 1
        q = _close_randomly(task, start, random)
        if q is None:
            continue
        closed += 1
        apart = _distance(task, q, found)
        if apart > _SAME:
            free = null_space(task.slopes(q), rcond=LOST)
            if apart > _SAME_SINGULAR or not free.size:
                found = np.vstack([found, q])
                singular += free.size > 0
            if singular > _SINGULAR:
                raise _left_free(task, free)
        unseen = len(found) * (len(found) + 1) / max(closed - len(found) - 2, 1)
    rows = equations.description.coordinates
    guesses = [{rows[k].name: float(q[k]) for k in np.flatnonzero(task.free)} for q in found]
    modes = [assemble(equations, t, guess, start_at) for guess in guesses or [{}]]
    positions = np.array([mode.q for mode in modes])
    names, signs = distinguishing_signs(equations, t, positions, task.free)
    order = sorted(range(len(modes)), key=lambda k: (*-signs[k], *positions[k].round(6)))
    labels = tuple("".join("+" if sign > 0 else "-" for sign in signs[k]) for k in order)
    title, modes = equations.description.title, [modes[k] for k in order]
    return AssemblyModes(title, tuple(modes), tuple(names), labels, starts, unseen)


def _closure(equations: Equations, t: float, start_at: Numbers | None) -> tuple[Start, Task]:
    """Start values and the closure problem; positions alone are looked for."""
    description = equations.description
    gears = [row.element for row in description.constraints if row.kind == "gear"]
    if gears or equations.is_large:
        why = f"{equations.n} coordinates are too many for random starts"
        why = f"gears close {listed(gears)} also at angles at which no teeth mesh" if gears else why
        advice = "Assemble from guesses near the modes that are meant."
        raise AnalysisError(f"{description.title}: {why}. {advice}")
    start = start_values(equations.mechanism, None, start_at)
    held = start.fixed_q | np.array([row.is_state for row in description.coordinates], np.bool_)
    angles, none = ~description.is_length, np.zeros(equations.n, np.bool_)
    start = start._replace(fixed_q=held, fixed_v=none, given_q=angles)  # angles say which is near
    regular_start.allow(equations.start, start)
    regular_start.let_lead(equations.start)
    size, every = equations.size(t, start.q), np.ones(equations.m, np.bool_)
    scale, row_scale = equations.scale(size), equations.row_scale(t, start.q, size)
    return start, Task(equations, t, scale, row_scale, every, ~held, regular_start.weights(start))


def _close_randomly(task: Task, start: Start, random: np.random.Generator) -> FloatArray | None:
    """A closed position, (n,), from angles anywhere in a turn; None if the joints stay open."""
    equations, turns = task.equations, ~task.equations.description.is_length & task.free
    angles, lengths = random.uniform(-np.pi, np.pi, equations.n), random.normal(size=equations.n)
    moves = np.where(turns, angles, lengths * task.scale * task.free)
    table, q, v = equations.start.table, start.q + moves, np.zeros(equations.n)
    found = regular_start.assemble_regular(table, task.t, equations.p, q, v)
    if found != regular_start.REGULAR and np.abs(task.gaps(q)).max(initial=0.0) <= ROUGH:
        q = refine(task, q)
    back = q - np.where(turns, _TURN * np.round((q - start.q) / _TURN), 0.0)
    for near in (back, q):  # belts may tell turns apart
        if np.abs(task.gaps(near)).max(initial=0.0) <= CLOSED:
            return near
    return None


def _distance(task: Task, q: FloatArray, others: FloatArray) -> float:
    """The distance to the nearest of other positions, (K, n), scaled; whole turns are none."""
    apart, is_length = np.abs(q - others) / task.scale, task.equations.description.is_length
    apart -= np.where(is_length, 0.0, _TURN * np.round(apart / _TURN))
    return float(np.abs(apart).max(axis=1).min(initial=np.inf))


def _left_free(task: Task, free: FloatArray) -> AnalysisError:
    """The error of positions that can move along `free`, (f, degrees of freedom)."""
    description, moves = task.equations.description, np.abs(free).max(axis=1) > LOST
    rows = [description.coordinates[k] for k in np.flatnonzero(task.free)[moves]]
    names = [row.name for row in sorted(rows, key=lambda row: not row.is_angle)]
    return AnalysisError(
        f"{description.title}: {counted(free.shape[1], 'degree')} of freedom left: with closed "
        f'joints move {listed(names)}. Hold it with start={{"{names[0]}": ...}}, or load a scene '
        "whose drivers do."
    )
