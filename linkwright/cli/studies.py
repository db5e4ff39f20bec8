"""Commands that run a scene many times: accuracy, matters, sweep."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from codegen.errors import InputError
from codegen.termination_signals import keep_results
from linkwright.cli import completion
from linkwright.cli.options import (
    Analysis,
    MotionStart,
    OptionalTEnd,
    Points,
    Request,
    examples,
    formulation,
    integration,
    method,
    output,
    scene,
    series,
    study,
    time,
    with_request,
)
from linkwright.cli.output import print_json, write_line

app = typer.Typer()
command = partial(app.command, rich_help_panel="Study")
quantity_of_study = partial(series, panel="Study")


@command(epilog=examples("linkwright accuracy four_bar.py --scene swing --t-end 1 --quick"))
@with_request(simulates=True, without=("accuracy", "quantities", "rtol", "correction"))
def accuracy(
    request: Request,
    quantity: Annotated[
        list[str] | None,
        quantity_of_study("A series that is compared, such as crank.phi; again for more. Unless "
                          "given, the coordinates that the scene starts from, and their "
                          "velocities. a.x|b.x is whichever of them a scene has."),
    ] = None,
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    method: Annotated[
        list[str] | None, method("Integration method; again for more. All unless given.")
    ] = None,
    formulation: Annotated[
        list[str] | None, formulation("cartesian or reduced; both unless given.")
    ] = None,
    reference: Annotated[
        Path | None,
        study("A .csv file with columns t, in s, and the quantities: the reference.",
              metavar="FILE"),
    ] = None,
    points: Annotated[int, time("Instants at which runs are compared.")] = 200,
    modelling: Annotated[
        bool, study("Run the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    beside: Annotated[
        list[str] | None,
        scene("A further scene that models the same machine; again for more."),
    ] = None,
    building: Annotated[
        bool | None, study("Build the scene anew and time each stage; not with --quick.")
    ] = None,
    quick: Annotated[
        bool, study("Four tolerances in place of seventeen, few repeats.", "--quick")
    ] = False,
    limit: Annotated[float, study("Seconds that a run may take.")] = 10.0,
    out: Annotated[
        Path | None, output("Folder for the picture and the runs as JSON lines.")
    ] = None,
) -> None:  # fmt: skip
    """What each digit costs: digits against time, by method, formulation and modelling choice."""
    from runtime.integrate.method import METHODS
    from runtime.studies.harness import FORMULATIONS
    from runtime.studies.pictures import check_folder, save_diagram
    from runtime.studies.work_precision import accuracy as work_precision

    diagram = _carry_out(
        request, out, check_folder, save_diagram,
        lambda: work_precision(
            *request.source(), quantities=tuple(quantity or ()), t_end=t_end, t_start=t_start,
            methods=tuple(method or METHODS), formulations=tuple(formulation or FORMULATIONS),
            points=points, reference=reference, modelling=modelling, beside=tuple(beside or ()),
            building=building, quick=quick, limit=limit, generated=request.generated,
            progress=write_line, **request.words(),
        ),
    )  # fmt: skip
    if not request.as_json:
        from codegen.presentation import show
        from runtime.studies.conclusions import score, sentences, work

        show((score(diagram), work(diagram)), sentences(diagram))


@command(
    epilog=examples(
        "linkwright matters four_bar.py --scene swing --t-end 2 --quantity max:rocker.phi"
    )
)
@with_request(simulates=True, without=("accuracy", "quantities"))
def matters(
    request: Request,
    quantity: Annotated[
        str,
        quantity_of_study("A coordinate, velocity, a(coordinate), reaction, energy or power at the "
                          "end; max:, min:, peak:, range:, mean:, rate: or period: of one; "
                          "event:EFFECT, count:EFFECT."),
    ],
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    error: Annotated[
        float | None,
        study("Relative change that is permitted; proposes the cheapest scene."),
    ] = None,
    analysis: Analysis = None,
    fidelities: Annotated[
        bool, study("Try the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    method: Annotated[str, method("Integration method, as in simulate.")] = "dop853",
    formulation: Annotated[str | None, formulation("cartesian or reduced, as in simulate.")] = None,
    rtol: Annotated[
        float,
        integration("Relative tolerance; a run with 100 times this is compared.",
                    metavar="NUMBER"),
    ] = 1e-10,
    points: Annotated[
        int, time("Number of output instants, ends included.")
    ] = 1001,
    rounds: Annotated[
        int | None, study("Timed runs of each scene; the least time counts.")
    ] = None,
    out: Annotated[Path | None, output("Picture: .png, .svg or .pdf.")] = None,
) -> None:  # fmt: skip
    """Which effects a quantity needs: its change without each of them, and the time that saves."""
    from codegen.presentation import check_picture
    from runtime.studies.effect_ranking import matters as rank_effects
    from runtime.studies.pictures import save_ranking

    ranking = _carry_out(
        request, out, check_picture, save_ranking,
        lambda: rank_effects(
            *request.source(), asked=quantity, t_end=t_end, t_start=t_start, error=error,
            analysis=analysis, fidelities=fidelities, method=method, formulation=formulation,
            rtol=rtol, points=points, rounds=rounds, generated=request.generated,
            progress=write_line, **request.words(),
        ),
    )  # fmt: skip
    if not request.as_json:
        from codegen.presentation import show
        from runtime.studies.ranking import ranking_table, sentences

        show((ranking_table(ranking),), sentences(ranking))


def _carry_out(
    request: Request, out: Path | None, check: Callable[[Path], None],
    save: Callable[[Any, Path], Iterable[Path]], analyse: Callable[[], Any],
) -> Any:  # fmt: skip
    """Run a study and save its picture where the `check` permits; with --json print its facts."""
    if out is not None:
        check(out)
    done = analyse()
    if out is not None:
        for path in save(done, out):
            write_line(f"Saved: {path}")
    if request.as_json:
        print_json({"ok": True, **done.facts()})
    return done


@command(
    epilog=examples(
        "linkwright sweep four_bar.py --t-end 2 --over AB=0.06:0.1:9 --quantity C.fx --out s.zarr"
    )
)
@with_request(simulates=True, without=("quantities",))
def sweep(
    request: Request,
    over: Annotated[
        list[str],
        study("A parameter or start value that varies: NAME=FIRST:LAST:COUNT, NAME=A,B,C, "
              "NAME=LOW:HIGH (uniform) or NAME=normal:MEAN:SD; again for more.",
              metavar="NAME=VALUES", autocompletion=completion.settings),
    ],
    quantity: Annotated[
        list[str],
        quantity_of_study("A number that is kept of each run, as in matters: max:B.fx, bob.phi "
                          "(at the end), event:latch; again for more."),
    ],
    out: Annotated[
        Path, output("Folder of the Zarr store to write, study.zarr.")
    ],
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    sample: Annotated[
        str | None,
        study("Sample in place of a grid: lhs, sobol, halton, random, or saltelli for Sobol's "
              "indices."),
    ] = None,
    count: Annotated[int | None, study("Points of a sample.", min=1)] = None,
    seed: Annotated[int, study("Seed of a sample.", min=0)] = 0,
    keep: Annotated[
        list[str] | None,
        series("A series that is kept of each run; again for more.", panel="Output"),
    ] = None,
    analysis: Analysis = None,
    points: Points = None,
    workers: Annotated[
        int | None,
        study("Processes on this computer: as many as it has cores unless given; 0: none "
                       "but this one.", min=0),
    ] = None,
    scheduler: Annotated[
        str | None,
        study("Address of a Dask scheduler, whose cluster makes the runs."),
    ] = None,
    resume: Annotated[
        bool, output("Go on with a sweep that was stopped: what is done stays.", "--resume")
    ] = False,
    picture: Annotated[
        Path | None,
        output("Picture of the first quantity: .png, .svg or .pdf."),
    ] = None,
) -> None:  # fmt: skip
    """Run a scene for many values of its parameters, into a Zarr store; it can be resumed."""
    from codegen.presentation import check_picture, save_picture
    from runtime.sweeps.sweep import sweep as make

    if picture is not None:
        check_picture(picture)
    if points is None and request.case and isinstance(request.case.run.get("t_eval"), list | str):
        raise InputError(
            f"{request.case.path}: run.t_eval lists output instants, and a sweep takes so many at "
            "equal distances; give their number, in the case or by --points."
        )
    keep_results()
    varied = {text.partition("=")[0].strip() for text in over}
    done = make(
        *request.source(), over=over, quantities=quantity, out=out, t_end=t_end, t_start=t_start,
        sample=sample, count=count, seed=seed, keep=tuple(keep or ()), points=points or 501,
        analysis=analysis, workers=workers, scheduler=scheduler, resume=resume,
        generated=request.generated, **request.words(varied=varied),
    )  # fmt: skip
    good = done.complete and "OK" in done.outcomes
    for line in repr(done).splitlines():
        write_line(line)
    if picture is not None and done.complete:
        save_picture(done.plot(), picture)
        write_line(f"  Saved: {picture}")
    if request.as_json:
        print_json({"ok": good, **done.facts()})
    raise typer.Exit(0 if good else 1)
