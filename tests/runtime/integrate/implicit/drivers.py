"""Ways in from Python to parts of implicit steps, which compiled code alone calls; their arrays."""

import numpy as np

from runtime.core.arrays import f8, i8, integers, none, vector
from runtime.core.jit import compiled
from runtime.core.workspace_rows import ATOL, PARTITION, SIZE
from runtime.core.workspace_rows import ROWS as WORKSPACE_ROWS
from runtime.integrate.implicit import bdf, bdf_history, radau5, simplified_newton, state_space_form
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.wiring import wire


class Arrays:
    """The table of a run, and views of its arrays."""

    def __init__(self, system, p, method="radau5", rtol=1e-6):
        self.wiring = wire(system, method, np.asarray(p, dtype=float), 1)
        self.table, arrays, n = self.wiring.table, self.wiring.arrays, system.coordinates
        self.n, self.numbers, self.notes = n, arrays["method_floats"], arrays["method_integers"]
        end = mem.NUMBERS + 2 * n * mem.ROWS
        self.rows = self.numbers[mem.NUMBERS : end].reshape(mem.ROWS, 2 * n)
        self.matrices = self.numbers[end:]
        self.workspace = arrays["workspace"].reshape(WORKSPACE_ROWS, 2 * n)
        self.record = arrays["record"][0]
        self.record["rtol"] = rtol
        self.workspace[SIZE], self.workspace[ATOL] = 1.0, rtol

    def set_independent(self, *places):
        self.workspace[PARTITION, : self.n] = 1.0
        self.workspace[PARTITION, list(places)] = 0.0

    def set_derivatives(self, by_u, by_rate):
        """Take all coordinates as unknowns, with these matrices."""
        f = len(by_u)
        self.notes[mem.FREEDOMS], self.notes[mem.COUNTS : mem.COUNTS + f] = f, np.arange(f)
        self.matrices[: f * f] = np.ravel(by_u)
        self.matrices[self.n**2 : self.n**2 + f * f] = np.ravel(by_rate)

    def derivatives(self):
        f = self.notes[mem.FREEDOMS]
        parts = self.matrices[: f * f], self.matrices[self.n**2 : self.n**2 + f * f]
        return [part.reshape(f, f) for part in parts]


@compiled(i8(integers))
def list_unknowns(context):
    return state_space_form.list_unknowns(context)


@compiled(i8(integers, f8, i8, i8))
def evaluate(context, t, state, derivative):
    return state_space_form.evaluate(context, t, state, derivative)


@compiled(i8(integers, f8, vector))
def solve_real(context, c, x):
    failed = simplified_newton.factor_real(context, c)
    simplified_newton.solve_factored(context, mem.REAL, x)
    return failed


@compiled(i8(integers, f8, f8, vector))
def solve_complex(context, c, d, x):
    failed = simplified_newton.factor_complex(context, c, d)
    simplified_newton.solve_factored(context, mem.COMPLEX, x)
    return failed


@compiled(f8(integers, f8, vector))
def filtered_error(context, c, raw):
    simplified_newton.factor_real(context, c)
    return simplified_newton.filtered_error(context, 0.0, 0, c, raw)


@compiled(none(integers, f8, vector))
def set_tolerance(context, share, ahead):
    simplified_newton.set_tolerance(context, share, 1e-3, 0, 0.1, ahead)


@compiled(f8(integers, f8))
def estimate_spectrum(context, h):
    state_space_form.estimate_spectrum(context)
    return state_space_form.stiffness(context, h)


@compiled(i8(integers, f8))
def suits_explicit(context, h):
    return state_space_form.suits_explicit(context, h)


@compiled(none(integers, f8))
def predict_stages(context, h):
    radau5.predict_stages(context, h)


@compiled(none(integers, vector, vector))
def write_polynomial(context, f2, f3):
    radau5.write_polynomial(context, f2, f3)


@compiled(i8(integers, f8, f8))
def radau5_step(context, t, h):
    return radau5.stages(context, t, h)


@compiled(f8(integers, f8))
def radau5_propose(context, h):
    return radau5.propose(context, h)


@compiled(i8(integers, f8, f8))
def bdf_step(context, t, h):
    return bdf.stages(context, t, h)


@compiled(i8(integers, f8, f8))
def bdf_evaluate(context, t, c):
    return bdf.evaluate_end(context, t, c)


@compiled(f8(integers, f8))
def bdf_propose(context, h):
    return bdf.propose(context, h)


@compiled(none(integers, f8))
def extrapolate_history(context, h):
    bdf_history.rescale_history(context, h)
    bdf_history.extrapolate(context)


@compiled(none(integers, f8))
def extend_history(context, h):
    bdf_history.extend_history(context, h)
    bdf_history.dense(context, 0.0, h)
