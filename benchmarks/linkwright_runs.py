"""The machines of the problems in this program, and the floors: the same equations by hand.

All settings of both formulations and of the floor take turns in one process. The time of a run is
the processor time of its integration, which other processes do not lengthen.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.chain import SCENE, chain
from benchmarks.floor import andrews as floor_andrews
from benchmarks.floor import chain as floor_chain
from benchmarks.floor import slider_crank as floor_crank
from benchmarks.precision import Point
from benchmarks.problems import PROBLEMS, Problem
from benchmarks.space_machines import Platform
from codegen.reading.model_file import read_model
from models.hard.andrews import model as squeezer
from models.hard.n_four_bar import n_four_bar
from runtime import Machine, load
from runtime.studies.harness import processor_time

FORMULATIONS = ("reduced", "cartesian")
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(8, 27))
"""10⁻⁴ … 10⁻¹³, two a decade."""
ROUNDS = 15
ENOUGH = 0.2
"""Seconds of one run, beyond which three of it are enough, and one beyond ten times that."""
Floor = Callable[[float], tuple[Sequence[float], int, int]]


@dataclass(frozen=True)
class Entry:
    """A problem with its machine, the compared coordinates, and its floors by name."""

    problem: Problem
    declare: Callable[[Path], Machine]
    angles: tuple[str, ...]
    formulations: tuple[str, ...] = FORMULATIONS
    start: tuple[tuple[str, float], ...] = ()
    parameters: tuple[tuple[str, float], ...] = ()
    floors: tuple[tuple[str, Floor], ...] = ()


def slider_crank(folder: Path) -> Machine:
    """The compressor without its gas."""
    model = read_model("slider_crank").model
    return load(model, model.scene("compressor").without("gas"), folder=folder)


def of_loops(loops: int) -> Callable[[Path], Machine]:
    """The parallel four-bars in a row."""
    return lambda folder: load(n_four_bar(loops), "fall", folder=folder)


def in_space(name: str, scene: str = "") -> Callable[[Path], Machine]:
    """A machine of `models/space`; without a scene its first one, without drivers."""

    def declare(folder: Path) -> Machine:
        model = import_module(f"models.space.{name}").model
        if scene:
            return load(model, scene, folder=folder)
        first = next(iter(model.scenes.values()))
        return load(model, first.without(*first.drivers), folder=folder)

    return declare


def centre(body: str) -> tuple[str, ...]:
    """The coordinates of a body's centre of mass."""
    return tuple(f"{body}.{c}" for c in "xyz")


def one(answer: Callable[[float], tuple[float, int, int]]) -> Floor:
    """A floor with one angle."""

    def run(tolerance: float) -> tuple[Sequence[float], int, int]:
        angle, steps, rejected = answer(tolerance)
        return (angle,), steps, rejected

    return run


CRANK = Entry(
    PROBLEMS["slider_crank"],
    slider_crank,
    ("crank.phi",),
    floors=(("floor", one(floor_crank.answer)),),
)
ANDREWS = Entry(
    PROBLEMS["andrews"],
    lambda folder: load(squeezer, "released", folder=folder),
    ("K1.phi",),
    start=(("K1.phi", floor_andrews.START[0]), ("K1.omega", 0.0)),
    floors=(
        ("floor", one(floor_andrews.answer)),
        ("floor, closed form", one(floor_andrews.answer_closed)),
    ),
)
LINKS = len(PROBLEMS["chain_10"].reference)
CHAIN = Entry(
    PROBLEMS["chain_10"],
    lambda folder: load(chain(LINKS), SCENE, folder=folder),
    tuple(f"link_{k}.phi" for k in range(LINKS)),
    floors=(("floor", lambda tolerance: floor_chain.answer(LINKS, tolerance)),),
)
LONG_LINKS = len(PROBLEMS["chain_100"].reference)
LONG_CHAIN = Entry(
    PROBLEMS["chain_100"],
    lambda folder: load(chain(LONG_LINKS), SCENE, folder=folder),
    tuple(f"link_{k}.phi" for k in range(LONG_LINKS)),
    ("cartesian",),
)
ENTRIES = {
    "slider_crank": CRANK,
    "andrews": ANDREWS,
    **{
        # Its loops are closed in closed form when reduced, and end at their dead centres.
        name: Entry(problem, of_loops(int(name[11:])), ("crank_0.phi",), ("cartesian",))
        for name, problem in PROBLEMS.items()
        if name.startswith("n_four_bar_")
    },
    "chain_10": CHAIN,
    "chain_100": LONG_CHAIN,
    "bricard": Entry(PROBLEMS["bricard"], in_space("bricard", "fall"), centre("b3")),
    "spatial_slider_crank": Entry(
        PROBLEMS["spatial_slider_crank"], in_space("spatial_slider_crank", "free"), centre("rod")
    ),
    "stewart_platform": Entry(
        PROBLEMS["stewart_platform"],
        in_space("stewart_platform", "springs"),
        centre("plate"),
        start=(
            *zip(centre("plate"), Platform.place, strict=True),
            *zip(("plate.e1", "plate.e2", "plate.e3"), Platform.vector, strict=True),
        ),
        parameters=(("damping", 0.0),),
    ),
    "six_revolute_arm": Entry(
        PROBLEMS["six_revolute_arm"], in_space("six_revolute_arm"), centre("tool")
    ),
}


def simulated(entry: Entry, machine: Machine, formulation: str, tolerance: float) -> Any:
    """One run to the end of the problem, and its time in ms."""
    run = machine.simulate(
        entry.problem.duration,
        [0.0, entry.problem.duration],
        rtol=tolerance,
        formulation=formulation,  # type: ignore[arg-type]  # one of the two words
        start=dict(entry.start) or None,
        parameters=dict(entry.parameters) or None,
        progress=False,
    )
    return run, float(run.stats["integration_seconds"]) * 1e3


@cache
def machine_of(entry: Entry, folder: Path) -> Machine:
    """The machine, built once."""
    return entry.declare(folder)


def measure(
    entry: Entry,
    folder: Path,
    rounds: int = ROUNDS,
    tolerances: Sequence[float] = TOLERANCES,
    machine: Machine | None = None,
) -> list[Point]:
    """All points of the floors and of ours, taken in turns."""
    machine = machine or machine_of(entry, folder)
    points: dict[tuple[str, str, float], Point] = {}
    answers = [
        (name, answer, tolerance) for name, answer in entry.floors for tolerance in tolerances
    ]
    ours = [(formulation, tol) for formulation in entry.formulations for tol in tolerances]
    for turn in range(rounds + 1):
        for name, answer, tolerance in answers:
            (angles, steps, rejected), seconds = processor_time(partial(answer, tolerance))
            calls = 12 * steps + 11 * rejected + 1
            error = entry.problem.error(angles)
            _keep(points, Point("floor", name, tolerance, error, 1e3 * seconds, calls), turn)
        for formulation, tolerance in ours:
            known = points.get(("linkwright", formulation, tolerance))
            if (
                known
                and turn > (1 if known.milliseconds > 1e4 * ENOUGH else 3)
                and (known.milliseconds > 1e3 * ENOUGH)
            ):
                continue
            run, took = simulated(entry, machine, formulation, tolerance)
            error = entry.problem.error([float(run.q(name)[-1]) for name in entry.angles])
            calls, note = int(run.stats["rhs_evaluations"]), run.message if run.failed else ""
            made = Point("linkwright", formulation, tolerance, error, took, calls, note)
            _keep(points, made, turn)
    return list(points.values())


def _keep(points: dict[tuple[str, str, float], Point], made: Point, turn: int) -> None:
    """The least time counts; the first turn is for caches and does not, unless it is the only."""
    key = (made.contestant, made.method, made.setting)
    known = points.get(key)
    if known is None or turn == 1 or made.milliseconds < known.milliseconds:
        points[key] = made


def checked_branch(entry: Entry, folder: Path, tolerance: float) -> tuple[float, float]:
    """Of the four-bars in a row: how far any crank leaves the first, rad, and the energy's error.

    On the right branch all cranks stay parallel at every instant; the energy's error is in parts
    of its range.
    """
    instants = np.linspace(0.0, entry.problem.duration, 401)
    run = machine_of(entry, folder).simulate(
        entry.problem.duration, instants, rtol=tolerance, progress=False
    )
    first = run.q("crank_0.phi")
    loops = int(entry.problem.name[11:])
    apart = max(
        float(np.abs(np.sin(run.q(f"crank_{k}.phi") - first)).max()) for k in range(loops + 1)
    )
    energy = np.zeros_like(first)
    names = [f"crank_{k}" for k in range(loops + 1)] + [f"coupler_{k + 1}" for k in range(loops)]
    for name in names:
        speed = run.v(f"{name}.x") ** 2 + run.v(f"{name}.y") ** 2 + run.v(f"{name}.phi") ** 2 / 12
        energy += 0.5 * speed + 9.81 * run.q(f"{name}.y")
    span = 2.0 * 9.81 * (0.5 * (loops + 1) + loops)
    return apart, float(np.abs(energy - energy[0]).max()) / span


def pace(rounds: int = 20) -> float:
    """Milliseconds of the slider-crank's floor at 10⁻⁹: how fast the machine is at the moment."""
    floor_crank.answer(1e-9)
    run = partial(floor_crank.answer, 1e-9)
    return 1e3 * min(processor_time(run)[1] for _ in range(rounds))
