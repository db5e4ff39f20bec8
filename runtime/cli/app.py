"""The command line: `python -m runtime simulate | kinematics | … | report | matters | accuracy`.

Exit status: 0 done, 1 the run failed (the message says at which t, and what was saved), 2 the
user's input is wrong. Messages and progress go to stderr; with --json, stdout holds one object.
"""

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from codegen.errors import InputError, LinkwrightError
from runtime.cli.accuracy import accuracy
from runtime.cli.common import pairs, print_json, refuse, say
from runtime.cli.matters import matters
from runtime.integrate.method import METHODS, alternatives

if TYPE_CHECKING:
    from runtime.integrate.problem import Correction, Formulation
    from runtime.machine import Machine
    from runtime.results.result import Result

app = typer.Typer(
    name="runtime",
    help="Analyse a mechanism: how it moves, how it must move, where it rests, what that takes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(matters)
app.command()(accuracy)

Model = Annotated[str, typer.Argument(help="Path of a model file, or a name: models/NAME.py.")]
Scene = Annotated[str | None, typer.Option(help="Scene of the model; the first unless given.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", help="NAME=VALUE: a parameter, in its declared unit.")
]
Guess = Annotated[
    list[str] | None, typer.Option("--guess", help="NAME=VALUE: a start value, in SI units.")
]
Out = Annotated[
    Path | None, typer.Option(help="File for the result: .nc, .csv, .parquet or .html.")
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
TEnd = Annotated[float, typer.Option("--t-end", help="Last instant in s.")]
TStart = Annotated[
    float, typer.Option("--t-start", help="First instant in s; the start values belong to t = 0.")
]
TBegin = Annotated[
    float, typer.Option("--t-start", help="First instant in s; the start values belong to it.")
]
Points = Annotated[int, typer.Option(min=2, help="Number of output instants, ends included.")]


@app.command()
def simulate(
    model: Model,
    t_end: TEnd,
    t_start: TBegin = 0.0,
    scene: Scene = None,
    settings: Settings = None,
    guess: Guess = None,
    points: Points = 501,
    accuracy: Annotated[
        float | None,
        typer.Option(
            help="Relative error that the result may have, in place of tolerances; the program "
            "chooses what is not given."
        ),
    ] = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            help="With --accuracy: a series that is meant; all coordinates and velocities."
        ),
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(help=f"Integration method: {alternatives(METHODS)}; dop853 unless given."),
    ] = None,
    rtol: Annotated[
        float | None, typer.Option(help="Relative tolerance of a step; 1e-8 unless given.")
    ] = None,
    atol: Annotated[float | None, typer.Option(help="Absolute tolerance in SI units.")] = None,
    correction: Annotated[
        str,
        typer.Option(
            help="Return onto the constraints: step, stage, projection, baumgarte or hybrid."
        ),
    ] = "step",
    formulation: Annotated[
        str | None,
        typer.Option(
            help="Coordinates that are integrated: cartesian (unless given), all of them, or "
            "reduced, those that no constraint gives."
        ),
    ] = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Dynamics: how the machine moves under the forces that act on it."""

    def analyse(machine: "Machine") -> "Result":
        return machine.simulate(
            t_end=t_end,
            # A run of no length is the assembled state; every other one has a positive span.
            t_eval=[t_end] if t_end == t_start else _instants(t_start, t_end, points),
            t_start=t_start,
            accuracy=accuracy,
            quantities=quantity,
            method=method,
            rtol=rtol,
            atol=atol,
            correction=cast("Correction", correction),  # refused there if it is none
            formulation=cast("Formulation | None", formulation),
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
        )

    _run(analyse, model, scene, out, as_json)


@app.command()
def kinematics(
    model: Model,
    t_end: TEnd,
    t_start: TStart = 0.0,
    scene: Scene = None,
    settings: Settings = None,
    guess: Guess = None,
    points: Points = 501,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Kinematics: how the machine must move, with drivers for all its freedom."""
    _run(
        lambda machine: machine.kinematics(
            _instants(t_start, t_end, points),
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
        ),
        model,
        scene,
        out,
        as_json,
    )


@app.command()
def inverse(
    model: Model,
    t_end: TEnd,
    t_start: TStart = 0.0,
    scene: Scene = None,
    settings: Settings = None,
    guess: Guess = None,
    points: Points = 501,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Inverse dynamics: what it takes to move the machine as its drivers say."""
    _run(
        lambda machine: machine.inverse_dynamics(
            _instants(t_start, t_end, points),
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
        ),
        model,
        scene,
        out,
        as_json,
    )


@app.command()
def report(
    model: Model,
    out: Annotated[Path, typer.Option(help="The page to write, .html.")],
    t_end: Annotated[float, typer.Option("--t-end", help="Last instant in s.")] = 1.0,
    scene: Scene = None,
    settings: Settings = None,
    guess: Guess = None,
    points: Points = 501,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-8,
    as_json: Json = False,
) -> None:
    """A page about a run: simulation, or the driven motion where drivers leave no freedom."""

    def analyse(machine: "Machine") -> "Result":
        values = pairs(settings, "--set")
        begin = pairs(guess, "--guess")
        instants = _instants(0.0, t_end, points)
        if machine.description.drivers and machine.degrees_of_freedom == 0:
            inverse = machine.description.has_masses
            driven = machine.inverse_dynamics if inverse else machine.kinematics
            return driven(instants, parameters=values, guess=begin)
        return machine.simulate(t_end, instants, rtol=rtol, parameters=values, guess=begin)

    if out.suffix != ".html":
        refuse((f"{out}: a report is an .html page. Change the ending.",), 2, as_json)
    _run(analyse, model, scene, out, as_json)


@app.command()
def equilibrium(
    model: Model,
    scene: Scene = None,
    settings: Settings = None,
    guess: Guess = None,
    method: Annotated[str, typer.Option(help="energy or settling.")] = "energy",
    t: Annotated[float, typer.Option(help="Instant at which the drivers are held, in s.")] = 0.0,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Equilibrium: where the machine rests, and whether it would stay there."""
    _run(
        lambda machine: machine.equilibrium(
            method,
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
            t=t,
        ),
        model,
        scene,
        out,
        as_json,
    )


def main() -> None:
    """Entry point."""
    app(prog_name="python -m runtime")


def _run(
    analyse: Callable[["Machine"], "Result"],
    model: str,
    scene: str | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Load, analyse, save, and say how it went; ends the process with the exit status."""
    try:
        if out is not None:
            from runtime.results.files import check_place

            check_place(out)
        from runtime.load import load

        result = analyse(load(model, scene))
        saved = None if out is None else result.save(out)
    except InputError as error:
        refuse(error.problems, 2, as_json)
    except (LinkwrightError, OSError) as error:
        refuse((str(error),), 1, as_json)
    from runtime.results.summary import accuracy, events, last_values, summary

    failed = result.failed
    say(repr(result))
    for line in (*accuracy(result), *events(result)):
        say(line)
    if saved is not None:
        count = len(result.t)
        upto = f" up to t = {result.t[-1]:g} s" if failed and count else ""
        say(f"  {'What was computed' if failed else 'Saved'}: {count} instants{upto} in {saved}")
    elif failed:
        say("  Nothing was saved; give --out FILE to keep what was computed.")
    if as_json:
        print_json(summary(result, saved))
    elif not failed:
        for line in last_values(result):
            sys.stdout.write(line + "\n")
    raise typer.Exit(1 if failed else 0)


def _instants(first: float, last: float, count: int) -> list[float]:
    """Equally spaced instants, ends included."""
    if not (math.isfinite(first) and math.isfinite(last) and last > first):
        raise InputError(f"The time span from {first:g} to {last:g} s must be finite and positive.")
    step = (last - first) / (count - 1)
    return [first + index * step for index in range(count - 1)] + [last]
