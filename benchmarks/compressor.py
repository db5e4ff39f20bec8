"""One second of the compressor: the runtime beside SciPy on the hand-reduced equation."""

import csv
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import numpy.typing as npt

from benchmarks import reduced

REFERENCE = Path(__file__).resolve().parent.parent / "tests" / "data" / "compressor_J450.csv"
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """One way to compute the run."""

    method: str
    rtol: float
    milliseconds: float
    error: float
    evaluations: int


def reference() -> tuple[Array, Array]:
    """Instants and crank angles of an independent solution, to 1e-10 rad."""
    with REFERENCE.open(encoding="utf-8", newline="") as stream:
        lines = (line for line in stream if not line.startswith("#"))
        rows = [(float(row["t"]), float(row["phi1"])) for row in csv.DictReader(lines)]
    t, phi = np.array(rows).T
    return t, phi


def measure(repeats: int, tolerances: tuple[float, ...] = (1e-9,)) -> tuple[Row, ...]:
    """All ways, in turn, the least time of `repeats`; compilation is over before."""
    from runtime import load

    machine = load("slider_crank", scene="compressor")
    t, phi = reference()
    rows = []
    for rtol in tolerances:

        def compiled(rtol: float = rtol) -> tuple[Array, int]:
            result = machine.simulate(
                t_end=float(t[-1]), t_eval=t, method="dop853", rtol=rtol, atol=rtol, progress=False
            )
            return result.q("crank.phi"), int(result.stats["rhs_evaluations"])

        def scripted(rtol: float = rtol) -> tuple[Array, int]:
            run = reduced.plain(t, rtol, rtol)
            return run.phi, run.evaluations

        def careful(rtol: float = rtol) -> tuple[Array, int]:
            run = reduced.simulate(t, rtol, rtol)
            return run.phi, run.evaluations

        ways = {
            "runtime, dop853": compiled,
            "SciPy, DOP853, lambdified": scripted,
            "SciPy, DOP853, floats, restarts": careful,
        }
        best = dict.fromkeys(ways, np.inf)
        answers = {}
        for _ in range(repeats + 1):
            for name, way in ways.items():
                started = perf_counter()
                answers[name] = way()
                best[name] = min(best[name], perf_counter() - started)
        for name, (angle, evaluations) in answers.items():
            error = float(np.abs(angle - phi).max())
            rows.append(Row(name, rtol, best[name] * 1e3, error, evaluations))
    return tuple(rows)
