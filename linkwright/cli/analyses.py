"""Commands that analyse: equilibrium, kinematics, inverse dynamics, simulation, report."""

import math
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from codegen.errors import InputError
from codegen.object_display import counted, without_rounding
from codegen.presentation import is_page
from codegen.termination_signals import keep_results
from linkwright.cli.options import (
    MotionStart,
    Points,
    Request,
    TEnd,
    commands,
    option,
    output,
    time,
    with_request,
)
from linkwright.cli.output import print_json, write_error, write_line

if TYPE_CHECKING:
    from runtime.machine_facade import Machine
    from runtime.results.result import Result

app = typer.Typer()
command = commands(app, "Analyse")
Out = Annotated[
    Path | None, output(..., "File for the result: .nc, .zarr, .csv, .parquet, .mat or .html.")
]
TStart = Annotated[float, time(..., "First instant in s; the start values belong to t = 0.")]
_SHOWN = 12  # events, before it says how many more there are


@command("linkwright equilibrium four_bar.py --scene swing")
@with_request(without=("start",))
def equilibrium(
    request: Request, method: str = option("energy", "energy or settling."),
    t: float = time(0.0, "Instant at which drivers and forces are frozen, in s."), out: Out = None,
) -> None:  # fmt: skip
    """Find where the machine rests: a position of equilibrium, and whether it is stable."""
    _carry_out(
        request, out, lambda machine: machine.equilibrium(method, t=t, **request.words(machine))
    )


@command("linkwright kinematics four_bar.py --scene driven --t-end 1 --out motion.csv")
@with_request()
def kinematics(
    request: Request, t_end: TEnd, t_start: TStart = 0.0, points: Points = None, out: Out = None
) -> None:
    """Find how the machine must move: the motion that its drivers prescribe, leaving no freedom."""
    _carry_out(request, out, lambda machine: machine.kinematics(**_prescribed(request, machine)))


@command(
    "linkwright inverse-dynamics four_bar.py --scene driven --t-end 1", name="inverse-dynamics"
)
@command("linkwright inverse four_bar.py --scene driven --t-end 1 --out torque.csv", name="inverse")
@with_request()
def inverse(
    request: Request, t_end: TEnd, t_start: TStart = 0.0, points: Points = None, out: Out = None,
    unknown: list[str] | None = option(
        None, "An effect that does what drivers would; repeat for each.", metavar="NAME"
    ),
) -> None:  # fmt: skip
    """Find the forces and torques that a prescribed motion requires: inverse dynamics."""
    _carry_out(
        request, out, lambda machine: machine.inverse_dynamics(
            **_prescribed(request, machine) | ({"unknown": unknown} if unknown else {})
        ),
    )  # fmt: skip


@command(
    "linkwright simulate four_bar.py --t-end 5 --out run.nc",
    "linkwright simulate four_bar.py --t-end 5 --set AB=0.08 --json",
    "linkwright simulate four_bar.py --t-end 5 --accuracy 1e-6",
)
@with_request(simulates=True)
def simulate(
    request: Request, t_end: TEnd, t_start: MotionStart = 0.0, points: Points = None,
    out: Out = None,
    stream: bool = output(
        False, "Write --out, a new .zarr, in chunks during the run.",
        "--stream/--no-stream"
    ),
) -> None:  # fmt: skip
    """Find how the machine will move under the forces that act on it."""
    if stream and out is None:
        raise InputError("--stream: name the store, --out run.zarr.")
    store = out if stream else None
    _carry_out(
        request, out, lambda machine: machine.simulate(**_motion(request, machine), out=store),
        stream=stream,
    )  # fmt: skip


@commands(app, "Show")("linkwright report four_bar.py --t-end 5 --out run.html")
@with_request(simulates=True)
def report(
    request: Request, out: Path = output(..., "The page to write, .html."),
    t_end: TEnd = 1.0, t_start: MotionStart = 0.0, points: Points = None,
) -> None:  # fmt: skip
    """Write a page about a run: a simulation, or the driven motion if no freedom is left."""
    if not is_page(out):
        raise InputError(f"{out}: a report is an .html page. Change the ending.")

    def analyse(machine: "Machine") -> "Result":
        if not (machine.description.drivers and machine.is_determined):
            return machine.simulate(**_motion(request, machine))
        request.refuse_run_options(machine.description.title)
        has_masses = machine.description.has_masses
        driven = machine.inverse_dynamics if has_masses else machine.kinematics
        return driven(**_prescribed(replace(request, run={}), machine))

    _carry_out(request, out, analyse)


def _motion(request: Request, machine: "Machine") -> dict[str, Any]:
    """The words of a motion; as many instants as an option or a case says, or those of the case."""
    own, words = request.own, request.words(machine)
    instants = own.get("points") or words.pop("t_eval", 501)
    return {**words, "t_end": own["t_end"], "t_start": own["t_start"], "t_eval": instants}


def _prescribed(request: Request, machine: "Machine") -> dict[str, Any]:
    """The words of a prescribed motion; the start values of a case belong to its first instant."""
    words = _motion(request, machine)
    if request.case is not None:
        return words
    first, last, count = (words.pop(name) for name in ("t_start", "t_end", "t_eval"))
    if not (math.isfinite(first) and math.isfinite(last) and last > first):
        raise InputError(f"The time span from {first:g} to {last:g} s must be finite and positive.")
    import numpy as np

    return {**words, "t_end": np.linspace(first, last, count)}


def _carry_out(
    request: Request, out: Path | None, analyse: "Callable[[Machine], Result]", *,
    stream: bool = False,
) -> None:  # fmt: skip
    """Load, analyse, save and summarise; ends the process with the exit status."""
    if out is not None:
        from runtime.results.export import check_place

        check_place(out)
    machine = request.machine()
    keep_results()
    result = analyse(machine)
    saved = out if stream or out is None else save(result, out)
    failed = result.failed or saved != out
    error = [] if result.accuracy is None else result.accuracy.sentences()[1:]
    lines = [f"  t = {event.time:<14.9g} {event.text}" for event in result.events]
    if len(lines) > _SHOWN:
        half = _SHOWN // 2
        lines[half:-half] = [f"  … {len(lines) - 2 * half} more events …"]
    for line in (result.headline, *(f"  {sentence}" for sentence in error), *lines):
        write_line(line)
    if saved is not None:
        count = len(result.t)
        until = f" up to t = {result.t[-1]:g} s" if failed and count else ""
        subject = "What was computed" if failed else "Saved"
        write_line(f"  {subject}: {counted(count, 'instant')}{until} in {saved}")
    elif failed:
        write_line("  Nothing was saved; give --out FILE to keep what was computed.")
    if request.as_json:
        print_json(summary(result, saved))
    elif not failed:
        _print_ends(result)
    raise typer.Exit(1 if failed else 0)


def save(result: "Result", out: Path) -> Path:
    """Save a result, where that fails in the system's folder for temporary files: it took time."""
    try:
        return result.save(out)
    except InputError as error:
        folder = Path(tempfile.mkdtemp(prefix="linkwright-"))
        try:
            saved = result.save(folder / out.name)
        except InputError:
            folder.rmdir()
            raise error from None
        write_error(str(error))
        return saved


def summary(result: "Result", saved: Path | None) -> dict[str, Any]:
    """The JSON object of a run."""
    from runtime.results.samples import plain

    about, some = result.description, len(result.t) > 0

    def last(names: Iterable[str]) -> dict[str, Any]:
        return {name: plain(result.series(name)[0][-1]) for name in names} if some else {}

    events = [
        {"t": e.time, "name": e.name, "element": e.element, "what": e.what, "word": e.word}
        for e in result.events
    ]
    return {
        "ok": not result.failed,
        **result.facts(),
        "instants": len(result.t),
        "t": [float(result.t[0]), float(result.t[-1])] if some else [],
        "q": last(row.name for row in about.positions),
        "v": last(row.velocity for row in about.positions),
        **({"y": last(about.states.names)} if about.states else {}),
        "events": events,
        "saved": None if saved is None else str(saved),
    }


def _print_ends(result: "Result") -> None:
    """The least and greatest forces that inverse dynamics seeks; last values of coordinates."""
    about = result.description
    for row in about.reactions if result.analysis == "inverse dynamics" else ():
        if row.element in (about.unknown or about.drivers):
            values = result.series(row.name)[0]
            found = sorted(x for x in values if not math.isnan(x)) or [math.nan]
            ends = without_rounding((found[0], found[-1]))
            sys.stdout.write(f"{row.name}  {ends[0]:.9g} to {ends[1]:.9g} {row.unit}\n")
    names = [*(row.name for row in about.positions), *about.states.names]
    columns = [result.series(name) for name in names]
    ends = without_rounding(values[-1] for values, _ in columns)
    for name, value, (_, unit) in zip(names, ends, columns, strict=True):
        line = f"{name:<{max(map(len, names))}}  {value: .9g} {unit}"
        sys.stdout.write(line.removesuffix(" 1") + "\n")
