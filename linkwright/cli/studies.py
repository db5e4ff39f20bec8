"""Commands that run a scene many times: accuracy, matters, sweep.

Their options have the names of the arguments of the studies, whose defaults hold for the others.
"""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    commands,
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

if TYPE_CHECKING:
    from runtime.studies.answer import Answer

app = typer.Typer()
command = commands(app, "Study")
quantity = partial(series, panel="Study")
_CHOSEN = ("method", "formulation", "rtol", "correction")  # words of runs that a diagram compares


@command("linkwright accuracy four_bar.py --scene swing --t-end 1 --quick")
@with_request(simulates=True, without=("accuracy", *_CHOSEN))
def accuracy(
    request: Request,
    quantities: list[str] | None = quantity(
        None, "A series that is compared, such as crank.phi; repeat for more. Unless given, the "
        "coordinates that the scene starts from, and their velocities. a.x|b.x: whichever of the "
        "two a scene contains.", "--quantity"
    ),
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    methods: list[str] | None = method(
        None, "Integration method; repeat for more. All unless given.", "--method"
    ),
    formulations: list[str] | None = formulation(
        None, "cartesian or reduced; both unless given.", "--formulation"
    ),
    reference: Path | None = study(
        None, "A .csv file with columns t, in s, and the quantities: the reference.", metavar="FILE"
    ),
    points: int = time(200, "Instants at which runs are compared."),
    modelling: bool = study(
        True, "Run the other fidelities of rods, contacts and frictions as well."
    ),
    beside: list[str] | None = scene(
        None, "A further scene that models the same machine; repeat for more."
    ),
    building: bool | None = study(
        None, "Build the scene anew and time each stage; not with --quick."
    ),
    quick: bool = study(False, "Four tolerances in place of seventeen, few repeats.", "--quick"),
    limit: float = study(10.0, "Seconds that a run may take."),
    out: Path | None = output(None, "Folder for the picture and the runs as JSON lines."),
) -> None:  # fmt: skip
    """Measure the cost of each digit, by method, formulation and modelling choice."""
    from runtime.studies.pictures import check_folder, save_diagram
    from runtime.studies.work_precision import accuracy as work_precision

    _carry_out(request, out, check_folder, save_diagram, work_precision)


@command("linkwright matters four_bar.py --scene swing --t-end 2 --quantity max:rocker.phi")
@with_request(simulates=True, without=("accuracy", "quantities"))
def matters(
    request: Request,
    asked: str = quantity(
        ...,
        "A coordinate, velocity, a(coordinate), reaction, energy or power at the end; max:, min:, "
        "peak:, range:, mean:, rate:, period: before it; event:EFFECT, count:EFFECT.", "--quantity"
    ),
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    error: float | None = study(
        None, "Largest permitted relative change; the cheapest scene within it is proposed."
    ),
    analysis: Analysis = None,
    fidelities: bool = study(
        True, "Try the other fidelities of rods, contacts and frictions as well."
    ),
    method: str = method("dop853", "Integration method, as in simulate."),
    formulation: str | None = formulation(None, "cartesian or reduced, as in simulate."),
    rtol: float = integration(
        1e-10, "Relative tolerance; a run at 100 times it checks each run.", metavar="NUMBER"
    ),
    points: int = time(1001, "Number of output instants, ends included."),
    rounds: int | None = study(None, "Timed runs of each scene; the least time counts."),
    out: Path | None = output(None, "Picture: .png, .svg or .pdf."),
) -> None:  # fmt: skip
    """Find the effects that a quantity needs: its change and the time saved without each."""
    from codegen.presentation import check_picture
    from runtime.studies.effect_ranking import matters as rank_effects
    from runtime.studies.pictures import save_ranking

    _carry_out(request, out, check_picture, save_ranking, rank_effects)


def _carry_out(
    request: Request, out: Path | None, check: Callable[[Path], None],
    save: Callable[[Any, Path], Iterable[Path]], study: "Callable[..., Answer]",
) -> None:  # fmt: skip
    """Run a study, save its picture where the `check` permits, and print what it found."""
    from codegen.presentation import show

    if out is not None:
        check(out)
    own = {name: value for name, value in request.own.items() if name != "out"}
    found = study(
        *request.source(), **own, generated=request.generated, progress=write_line,
        **request.words(),
    )  # fmt: skip
    if out is not None:
        for path in save(found, out):
            write_line(f"Saved: {path}")
    if request.as_json:
        print_json({"ok": True, **found.facts()})
    else:
        show(found.tables(), found.sentences())


@command("linkwright sweep four_bar.py --t-end 2 --over AB=0.06:0.1:9 --quantity C.fx --out s.zarr")
@with_request(simulates=True)
def sweep(
    request: Request,
    over: list[str] = study(
        ...,
        "A parameter or start value that varies: NAME=FIRST:LAST:COUNT, NAME=A,B,C, NAME=LOW:HIGH "
        "(uniform) or NAME=normal:MEAN:SD; repeat for more.",
        metavar="NAME=VALUES", autocompletion=completion.settings
    ),
    quantities: list[str] = quantity(
        ..., "A number that is kept of each run, as in matters: max:B.fx, bob.phi (at the end), "
        "event:latch; repeat for more.", "--quantity"
    ),
    out: Path = output(..., "Folder of the Zarr store to write, study.zarr."),
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    sample: str | None = study(
        None,
        "Sample in place of a grid: lhs, sobol, halton, random, or saltelli for Sobol's indices."
    ),
    count: int | None = study(None, "Points of a sample.", min=1),
    seed: int = study(0, "Seed of a sample.", min=0),
    keep: list[str] | None = series(
        None, "A series that is kept of each run; repeat for more.", panel="Output"
    ),
    analysis: Analysis = None,
    points: Points = None,
    workers: int | None = study(
        None,
        "Processes on this computer, by default one for each core; 0: this process alone.",
        min=0
    ),
    scheduler: str | None = study(
        None, "Address of a Dask scheduler, whose cluster makes the runs."
    ),
    resume: bool = output(
        False, "Go on with a sweep that was stopped; finished runs remain.", "--resume"
    ),
    picture: Path | None = output(None, "Picture of the first quantity: .png, .svg or .pdf."),
) -> None:  # fmt: skip
    """Run a scene for many values of its parameters, into a Zarr store; --resume continues."""
    from codegen.presentation import check_picture, in_pyplot, save_picture
    from runtime.sweeps.sweep import sweep as make

    request.own.pop("picture", None)
    if picture is not None:
        check_picture(picture)
    if points is None and request.case and isinstance(request.case.run.get("t_eval"), list | str):
        raise InputError(
            f"{request.case.path}: run.t_eval lists output instants, and a sweep takes so many at "
            "equal distances; give their number, in the case or by --points."
        )
    keep_results()
    varied = {text.partition("=")[0].strip() for text in over}
    model, scene = request.source()
    words = request.own | request.words(varied=varied)
    done = make(model, scene, generated=request.generated, **words)
    good = done.complete and "OK" in done.outcomes
    for line in repr(done).splitlines():
        write_line(line)
    if picture is not None and done.complete:
        with in_pyplot(False):
            save_picture(done.plot(), picture)
        write_line(f"  Saved: {picture}")
    if request.as_json:
        print_json({"ok": good, **done.facts()})
    raise typer.Exit(0 if good else 1)
