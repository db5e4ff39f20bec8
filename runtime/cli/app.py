"""The command line: `python -m runtime simulate | kinematics | … | matters | accuracy | sweep`.

Exit status: 0 done, 1 the run failed (the message says at which t, and what was saved), 2 the
user's input is wrong, 128 + n stopped by signal n: 129 SIGHUP, 130 SIGINT, 143 SIGTERM. Messages
and progress go to stderr; with --json, stdout holds one object.
"""

import math
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from codegen.errors import InputError
from codegen.object_display import counted, without_rounding
from codegen.termination_signals import finish, keep_results
from runtime.cli import common, studies, sweep
from runtime.cli.case_of_command import case_in_force, load_machine
from runtime.cli.common import (
    Generated,
    Guess,
    Json,
    Model,
    MotionStart,
    Scene,
    Start,
    TEnd,
    TStart,
    Values,
    option,
)
from runtime.cli.run_options import refuse_run_options, with_run_options, words
from runtime.show.file_endings import is_page

if TYPE_CHECKING:
    from runtime.machine_facade import Machine
    from runtime.results.result import Result

app = typer.Typer(
    name="runtime",
    help="Analyse a mechanism: simulation, kinematics, inverse dynamics, equilibrium; reports, "
    "effect rankings, work-precision diagrams and sweeps.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(studies.matters)
app.command()(studies.accuracy)
app.command()(sweep.sweep)

Out = Annotated[
    Path | None, option("File for the result: .nc, .zarr, .csv, .parquet, .mat or .html.")
]
Stream = Annotated[
    bool, option("Write --out, a .zarr that is not there, in chunks while the run goes on.")
]
_SHOWN = 12  # events, before it says how many more there are
Points = Annotated[int, option("Number of output instants, ends included.", min=2)]


@app.command()
@with_run_options
def simulate(
    model: Model, t_end: TEnd, t_start: MotionStart = 0.0, scene: Scene = None,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None, points: Points = 501, out: Out = None, stream: Stream = False,
    as_json: Json = False, **run: Any,
) -> None:  # fmt: skip
    """Dynamics: the motion of the machine under the forces that act on it."""

    def analyse(machine: "Machine", **values: Any) -> "Result":
        given = {"t_eval": points, **words(run, values)}
        given |= {"out": out} if stream else {}
        return machine.simulate(t_end, t_start=t_start, **given)

    if stream and out is None:
        common.refuse(("--stream: name the store, --out run.zarr.",), 2, as_json)
    _run(analyse, model, scene, settings, guess, generated, out, as_json, start, stream=stream)


@app.command()
def kinematics(
    model: Model, t_end: TEnd, t_start: TStart = 0.0, scene: Scene = None,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None, points: Points = 501, out: Out = None, as_json: Json = False,
) -> None:  # fmt: skip
    """Kinematics: the motion that the drivers prescribe, one for every degree of freedom."""

    def analyse(machine: "Machine", **values: Any) -> "Result":
        return machine.kinematics(**_driven(t_start, t_end, points, values))

    _run(analyse, model, scene, settings, guess, generated, out, as_json, start)


@app.command("inverse-dynamics")
@app.command("inverse")
def inverse(
    model: Model, t_end: TEnd, t_start: TStart = 0.0, scene: Scene = None,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None, points: Points = 501, out: Out = None, as_json: Json = False,
) -> None:  # fmt: skip
    """Inverse dynamics: the forces that the prescribed motion takes."""

    def analyse(machine: "Machine", **values: Any) -> "Result":
        return machine.inverse_dynamics(**_driven(t_start, t_end, points, values))

    _run(analyse, model, scene, settings, guess, generated, out, as_json, start)


@app.command()
@with_run_options
def report(
    model: Model, out: Annotated[Path, option("The page to write, .html.")],
    t_end: TEnd = 1.0, t_start: MotionStart = 0.0, scene: Scene = None, settings: Values = None,
    start: Start = None, guess: Guess = None, generated: Generated = None, points: Points = 501,
    as_json: Json = False, **run: Any,
) -> None:  # fmt: skip
    """A page about a run: a simulation, or the driven motion where drivers leave no freedom."""

    def analyse(machine: "Machine", **values: Any) -> "Result":
        if machine.description.drivers and machine.is_determined:
            refuse_run_options(run, machine.description.title)
            inverse = machine.description.has_masses
            driven = machine.inverse_dynamics if inverse else machine.kinematics
            return driven(**_driven(t_start, t_end, points, values))
        given = {"t_eval": points, **words(run, values)}
        return machine.simulate(t_end, t_start=t_start, **given)

    if not is_page(out):
        common.refuse((f"{out}: a report is an .html page. Change the ending.",), 2, as_json)
    _run(analyse, model, scene, settings, guess, generated, out, as_json, start)


@app.command()
def equilibrium(
    model: Model, scene: Scene = None, settings: Values = None, guess: Guess = None,
    method: Annotated[str, option("energy or settling.")] = "energy",
    t: Annotated[float, option("Instant at which the drivers stand, in s.")] = 0.0,
    generated: Generated = None, out: Out = None, as_json: Json = False,
) -> None:  # fmt: skip
    """Equilibrium: the position of rest, and whether it is stable."""

    def analyse(machine: "Machine", **values: Any) -> "Result":
        return machine.equilibrium(method, t=t, **values)

    _run(analyse, model, scene, settings, guess, generated, out, as_json)


def main() -> None:
    """Entry point."""
    common.show_warnings_as_notes()
    try:
        app(prog_name="python -m runtime")
    finally:
        finish()


def _run(
    analyse: Callable[..., "Result"], model: str, scene: str | None, settings: list[str] | None,
    guess: list[str] | None, generated: Path | None, out: Path | None, as_json: bool,
    start: list[str] | None = None, *, stream: bool = False,
) -> None:  # fmt: skip
    """Load, analyse, save and summarise; ends the process with the exit status."""
    with common.exit_on_error(as_json):
        if out is not None:
            from runtime.results.export import check_place

            check_place(out)
        machine = load_machine(model, scene, generated)
        keep_results()
        result = analyse(machine, **common.start_values(settings, guess, start, machine))
        saved = out if stream or out is None else _save(result, out)
    failed = result.failed or saved != out
    error = [] if result.accuracy is None else result.accuracy.sentences()[1:]
    for line in (result.headline, *(f"  {sentence}" for sentence in error), *_event_lines(result)):
        common.write_line(line)
    if saved is not None:
        count = len(result.t)
        until = f" up to t = {result.t[-1]:g} s" if failed and count else ""
        subject = "What was computed" if failed else "Saved"
        common.write_line(f"  {subject}: {counted(count, 'instant')}{until} in {saved}")
    elif failed:
        common.write_line("  Nothing was saved; give --out FILE to keep what was computed.")
    if as_json:
        common.print_json(summary(result, saved))
    elif not failed:
        import numpy as np

        about = result.description
        names = [*(row.name for row in about.positions), *about.states.names]
        columns = [result.series(name) for name in names]
        ends = without_rounding(np.array([values[-1] for values, _ in columns]))
        for name, value, (_, unit) in zip(names, ends, columns, strict=True):
            sys.stdout.write(f"{name:<{max(map(len, names))}}  {value: .9g} {unit}\n")
    raise typer.Exit(1 if failed else 0)


def _save(result: "Result", out: Path) -> Path:
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
        common.write_line(f"error: {error}")
        return saved


def summary(result: "Result", saved: Path | None) -> dict[str, Any]:
    """The JSON object of a run."""
    from runtime.results.samples import plain

    about, some = result.description, len(result.t) > 0

    def last(names: Iterable[str], series: Callable[[str], Any]) -> dict[str, Any]:
        return {name: plain(series(name)[-1]) for name in names} if some else {}

    return {
        "ok": not result.failed,
        **result.facts(),
        "instants": len(result.t),
        "t": [float(result.t[0]), float(result.t[-1])] if some else [],
        "q": last([row.name for row in about.positions], result.q),
        "v": last([row.velocity for row in about.positions], result.v),
        **({"y": last(about.states.names, result.y)} if about.states else {}),
        "events": [
            {"t": e.time, "name": e.name, "element": e.element, "what": e.what, "word": e.word}
            for e in result.events
        ],
        "saved": None if saved is None else str(saved),
    }


def _event_lines(result: "Result") -> list[str]:
    """The events, a line each; of many, the first and the last ones."""
    happened = result.events
    lines = [f"  t = {e.time:<14.9g} {e.text}" for e in happened]
    if len(lines) <= _SHOWN:
        return lines
    half = _SHOWN // 2
    return [*lines[:half], f"  … {len(lines) - 2 * half} more events …", *lines[-half:]]


def _driven(t_start: float, t_end: float, points: int, values: dict[str, Any]) -> dict[str, Any]:
    """The arguments of a prescribed motion; the start values of a case belong to its first instant.

    A condition that ends a simulation is none of them.
    """
    of_motion = {name: value for name, value in values.items() if name != "until"}
    if case_in_force() is None:
        return {"t_end": _instants(t_start, t_end, points), **of_motion}
    return {"t_end": t_end, "t_eval": points, "t_start": t_start, **of_motion}


def _instants(first: float, last: float, count: int) -> list[float]:
    """Equally spaced instants, ends included."""
    if not (math.isfinite(first) and math.isfinite(last) and last > first):
        raise InputError(f"The time span from {first:g} to {last:g} s must be finite and positive.")
    step = (last - first) / (count - 1)
    return [first + index * step for index in range(count - 1)] + [last]
