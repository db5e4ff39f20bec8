"""`python -m runtime sweep`: many runs of a scene, with other values each time."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from codegen.termination_signals import keep_results
from runtime.cli import common
from runtime.cli.case_of_command import source
from runtime.cli.common import (
    Generated,
    Guess,
    Json,
    Model,
    MotionStart,
    OptionalTEnd,
    Scene,
    Start,
    Values,
    option,
)
from runtime.cli.run_options import with_run_options, words


@partial(with_run_options)
def sweep(
    model: Model,
    over: Annotated[
        list[str],
        option("A parameter or start value that varies: NAME=FIRST:LAST:COUNT, NAME=A,B,C, "
               "NAME=LOW:HIGH (uniform) or NAME=normal:MEAN:SD; again for more."),
    ],
    quantity: Annotated[
        list[str],
        option("A number that is kept of each run, as in matters: max:B.fx, bob.phi (at the end), "
               "event:latch; again for more."),
    ],
    out: Annotated[Path, option("Folder of the Zarr store to write, study.zarr.")],
    scene: Scene = None, t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    sample: Annotated[
        str | None,
        option("Sample in place of a grid: lhs, sobol, halton, random, or saltelli for Sobol's "
               "indices."),
    ] = None,
    count: Annotated[int | None, option("Points of a sample.", min=1)] = None,
    seed: Annotated[int, option("Seed of a sample.", min=0)] = 0,
    keep: Annotated[
        list[str] | None, option("A series that is kept of each run; again for more.")
    ] = None,
    analysis: Annotated[
        str | None,
        option("simulate, kinematics, inverse-dynamics or equilibrium (which needs no --t-end); "
               "follows from the scene unless given."),
    ] = None,
    points: Annotated[int, option("Output instants of a run, ends included.", min=2)] = 501,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None,
    workers: Annotated[
        int | None,
        option("Processes on this computer: as many as it has cores unless given; 0: none but this "
               "one.", min=0),
    ] = None,
    scheduler: Annotated[
        str | None, option("Address of a Dask scheduler, whose cluster makes the runs.")
    ] = None,
    resume: Annotated[
        bool, option("Go on with a sweep that was stopped: what is done stays.", "--resume")
    ] = False,
    picture: Annotated[
        Path | None, option("Picture of the first quantity: .png, .svg or .pdf.")
    ] = None,
    as_json: Json = False, **run: Any,
) -> None:  # fmt: skip
    """Sweep: many runs with other values each time, kept in a Zarr store; it can be resumed."""
    from runtime.studies.effect_ranking.picture import check_place
    from runtime.sweeps import sweep as make
    from runtime.sweeps.pictures import save

    with common.exit_on_error(as_json):
        if picture is not None:
            check_place(picture)
        keep_results()
        values = common.start_values(settings, guess, start)
        what, where = source(model, scene)
        study = make(
            what, where, over=over, quantities=quantity, out=out, t_end=t_end, t_start=t_start,
            sample=sample, count=count, seed=seed, keep=tuple(keep or ()), points=points,
            analysis=analysis, workers=workers, scheduler=scheduler, resume=resume,
            generated=generated, **words(run, values),
        )  # fmt: skip
        good = study.complete and "OK" in study.outcomes
        for line in repr(study).splitlines():
            common.write_line(line)
        if picture is not None and study.complete:
            save(study.plot(), picture)
            common.write_line(f"  Saved: {picture}")
    if as_json:
        common.print_json({"ok": good, **study.facts()})
    raise typer.Exit(0 if good else 1)
