"""Dormand-Prince 8(5,3) with a test of whether the equations have become stiff.

It starts with the explicit method of order 8, which needs the fewest evaluations where nothing is
stiff. Now and then the exact derivatives are taken and their spectral radius ρ is found. A step is
limited by stability where h ρ is at the edge of the region of stability; and also, as a method of
high order sees what is left of a fast motion long before the edge, where two things meet: the
fastest motion would turn by a good part of a radian in the step, and the accelerations change by
less than an implicit method would permit itself. After that has been so for many steps another
method is due, and the run changes over; see `successor`.
"""

from dataclasses import replace

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context, Vector
from runtime.core.jit import addressed, compiled
from runtime.core.loop_record import run_record
from runtime.core.workspace_rows import SIZE, Y0, K, row_of
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.state_space_form import differentiate, list_unknowns
from runtime.integrate.method import LEADING, find_method

_EXPLICIT = find_method(LEADING)
_stages, _LAST = _EXPLICIT.stages, _EXPLICIT.last
_EVERY = 10  # measured: steps between two estimates of the stiffness
# measured: h ρ that the explicit method hardly exceeds at tight tolerances, where it resolves the
# remaining fast motion; the edge of its stability is at 6.
_TURN = 0.3
_EDGE = 4.0  # measured: h ρ that no accuracy permits; the method is at its stability limit
_EASY = 0.5  # measured: of the relative change of accelerations in a Radau step, about rtol^(1/5)
_SEEN = 30  # measured: such steps before the method changes
_DOUBT = 2  # measured: such steps that are forgotten after a different one

_MANY = 20  # measured: unknowns from which on three stages at a time cost more than small steps
_LOOSE = 1e-5  # measured: relative tolerance down to which small steps are few

_DECAYED = mem.CHANGE  # place in METHOD_FLOATS: sum of -h Re λ over the steps


def successor(name: str, freedoms: int, rtol: float) -> str:
    """The method to change to from `name` ("auto" is the explicit one), with its reason.

    Radau IIA, whose region of stability holds the whole left half-plane, lightly damped vibrations
    included; BDF where there are many unknowns and little is asked.
    """
    if name != "auto":
        return "auto"
    return "bdf" if freedoms >= _MANY and rtol >= _LOOSE else "radau5"


def mean_decay(method_floats: Vector, steps: int) -> float:
    """Mean of -h Re λ over that many steps of "auto", λ the fastest motion's eigenvalue."""
    return float(method_floats[_DECAYED]) / max(1, steps)


@addressed(ft.STAGES)
def stages(context: Context, t: float, h: float) -> int:
    """Take the step from Y0 with derivative K to Y1, and look for stiffness at times."""
    if context.method_integers[mem.EQUAL] % _EVERY == 0:
        list_unknowns(context)
        differentiate(context, t, Y0)
    return _stages(context, t, h)


@compiled(ft.HOOK)
def accepted(context: Context, t: float, h: float) -> int:
    """Count the step; 1 where the steps have long been limited by stability."""
    r, n, notes = run_record(context), context[ft.COORDINATES], context.method_integers
    notes[mem.EQUAL] += 1
    size, before, after = row_of(context, SIZE), row_of(context, K), row_of(context, K + _LAST)
    change, largest = 0.0, 0.0
    for j in range(n, 2 * n):
        change = max(change, abs(after[j] - before[j]) / size[j])
        largest = max(largest, abs(after[j]) / size[j])
    easy = change < _EASY * r.rtol**0.2 * largest
    memory = context.method_floats
    turn = h * memory[mem.STIFFNESS]
    memory[_DECAYED] += turn * memory[mem.DAMPING]
    limited = turn > _EDGE or (easy and turn > _TURN)
    notes[mem.STIFF] = notes[mem.STIFF] + 1 if limited else max(0, notes[mem.STIFF] - _DOUBT)
    if notes[mem.STIFF] < _SEEN * r.patience:
        return 0
    notes[mem.STIFF] = 0
    return 1


METHOD = replace(_EXPLICIT, stages=stages, accepted=accepted, memory=mem.memory)
