"""Growth with size: operations, nanoseconds, and seconds of building by number of bars."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from benchmarks import linkwright_runs
from benchmarks.chain import SCENE, chain
from benchmarks.kernel_timing import interleaved, many_solutions, no_solution
from benchmarks.linkwright_runs import Entry
from benchmarks.precision import time_to
from benchmarks.problems import GRAVITY, Problem, n_four_bar
from benchmarks.report import Report, records
from codegen.files.generated_modules import companion_path, import_generated
from models.hard.n_four_bar import n_four_bar as loops_of
from runtime import Machine, load

SIZES = (1, 2, 5, 10)
TARGET = 1e-6
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(9, 20))
STATES = 64
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """A machine of one size in one formulation.

    Attributes
    ----------
    family, size, formulation
        Of the machine, and of its equations.
    operations
        Of a call of `accelerations`.
    nanoseconds
        A call of it.
    build
        Seconds from the declaration to machine code, SymPy and compiler together; of reduced
        coordinates those that come on top, as they need the module of all coordinates too.
    milliseconds
        To an error of `TARGET`; infinite where it is not reached.
    note
        Why a run failed, if it did.
    """

    family: str
    size: int
    formulation: str
    operations: int
    nanoseconds: float
    build: float
    milliseconds: float
    note: str = ""


def hanging(links: int, t_end: float = 2.0) -> tuple[float, ...]:
    """The angles of the chain after the time `t_end`, s: its equation in them, by SciPy."""
    arm = links - np.arange(links) - 0.5
    arms = np.minimum.outer(arm, arm)
    heavy = links - np.arange(links) - 2 / 3

    def slope(t: float, y: Array) -> Array:
        angle, speed = y[:links], y[links:]
        turned = angle[:, None] - angle
        matrix = arms * np.cos(turned)
        np.fill_diagonal(matrix, heavy)
        force = -GRAVITY * arm * np.cos(angle) - (arms * np.sin(turned)) @ speed**2
        return np.concatenate((speed, np.linalg.solve(matrix, force)))

    start = np.zeros(2 * links)
    found = solve_ivp(slope, (0.0, t_end), start, "DOP853", rtol=1e-13, atol=1e-13)
    return tuple(found.y[:links, -1].tolist())


def chain_entry(links: int) -> Entry:
    """A chain."""
    problem = Problem(f"chain_{links}", f"chain of {links}", 2.0, hanging(links), 1e-11)
    names = tuple(f"link_{k}.phi" for k in range(links))
    return Entry(problem, lambda folder: load(chain(links), SCENE, folder=folder), names)


def loops_entry(loops: int) -> Entry:
    """Parallel four-bars in a row."""
    return Entry(
        n_four_bar(loops),
        lambda folder: load(loops_of(loops), "fall", folder=folder),
        ("crank_0.phi",),
        ("cartesian",),
    )


FAMILIES: dict[str, Callable[[int], Entry]] = {"chain": chain_entry, "n_four_bar": loops_entry}


def kernel(machine: Machine, formulation: str, count: int, repeats: int) -> tuple[int, float]:
    """Operations and nanoseconds of a call of `accelerations`, near the start."""
    start, p = machine.assemble(), machine.parameter_values()
    q, v, rows, path = start.q, start.v, len(machine.constraints), machine.path
    kernels = machine.kernels
    if formulation == "reduced":
        reduced = machine.mechanism.reduced
        p, kernels = reduced.parameters(p, start.t, start.q), reduced.kernels
        q, v, rows = q[reduced.kept], v[reduced.kept], len(reduced.closures)
        path = companion_path(path, "reduced")
    random = np.random.default_rng(1)
    places = q + 1e-3 * random.normal(size=(STATES, len(q)))
    rates = v + 1e-3 * random.normal(size=places.shape)
    modes = np.zeros((STATES, 0), dtype=np.int64)
    # The empty loop writes and reads the third entry, which one angle alone has not.
    a, lam = np.zeros(max(3, len(q))), np.zeros(rows)
    if len(q) < len(a):
        places, rates = (np.pad(x, ((0, 0), (0, len(a) - len(q)))) for x in (places, rates))
    runs = {
        name: lambda n, call=call: many_solutions(call, n, places, rates, p, modes, a, lam)
        for name, call in (("kernel", kernels.accelerations), ("loop", no_solution))
    }
    best = interleaved(runs, count, repeats)
    counted = dict(import_generated(path).OPERATIONS)["accelerations"]
    return int(counted), best["kernel"] - best["loop"]


def built(entry: Entry, formulation: str, folder: Path) -> tuple[Machine, float]:
    """The machine with the kernels of a formulation, and how long they took to build."""
    began = time.perf_counter()
    machine = linkwright_runs.machine_of(entry, folder)
    if formulation == "reduced":
        began = time.perf_counter()
        _ = machine.mechanism.reduced.kernels
    return machine, time.perf_counter() - began


def measure(family: str, sizes: Sequence[int], folder: Path, quick: bool) -> list[Row]:
    """All sizes of a family in both formulations."""
    rows = []
    for size in sizes:
        entry = FAMILIES[family](size)
        for formulation in reversed(linkwright_runs.FORMULATIONS):
            machine, seconds = built(entry, formulation, folder)
            counted, cost = kernel(machine, formulation, *((2_000, 2) if quick else (50_000, 7)))
            rounds = 1 if quick else 4
            alone = replace(entry, formulations=(formulation,))
            points = linkwright_runs.measure(alone, folder, rounds, TOLERANCES, machine)
            note = next((point.note for point in points if point.note), "")
            took = time_to(TARGET, points)
            rows.append(Row(family, size, formulation, counted, cost, seconds, took, note))
    return rows


def reports(quick: bool, out: Path) -> list[Report]:
    """Both families, with a picture."""
    from benchmarks.growth_picture import draw

    sizes = SIZES[:3] if quick else SIZES
    with TemporaryDirectory() as folder:
        rows = [row for name in FAMILIES for row in measure(name, sizes, Path(folder), quick)]
    draw(rows, out / "growth.png")
    cells = [
        (
            row.family,
            row.formulation,
            str(row.size),
            str(row.operations),
            f"{row.nanoseconds:.0f}",
            f"{row.build:.1f}",
            f"{row.milliseconds:.3g}"
            if row.milliseconds < np.inf
            else "ends at a dead centre"
            if "dead centre" in row.note
            else "not reached",
        )
        for row in rows
    ]
    headings = ("machine", "formulation", "size", "operations", "ns", "build, s", "ms to 1e-6")
    title = "growth with size: a chain of bars, and parallel four-bars in a row"
    sentences = ["build, s: that of reduced coordinates comes on top of that of cartesian ones."]
    sentences += [
        exponent(rows, family, way) for family in FAMILIES for way in linkwright_runs.FORMULATIONS
    ]
    return [Report("growth", title, headings, cells, sentences, records(rows), 2)]


def exponent(rows: Sequence[Row], family: str, formulation: str) -> str:
    """With which power of the size operations grow between the two largest."""
    last = [r for r in rows if (r.family, r.formulation) == (family, formulation)][-2:]
    small, large = last
    power = np.log(large.operations / small.operations) / np.log(large.size / small.size)
    return (
        f"{family}, {formulation}: from size {small.size} to {large.size} the operations grow with "
        f"the power {power:.2f}."
    )
