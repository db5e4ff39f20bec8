"""Commands of the compiler: build, explain, precompile, methods."""

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from codegen.emit.line_wrapping import quantity
from codegen.errors import InputError, SceneError
from linkwright.cli import completion
from linkwright.cli.options import (
    AnyScene,
    Check,
    Json,
    ModelFile,
    ModelFiles,
    Values,
    examples,
    option,
    output,
    parameters,
    study,
)
from linkwright.cli.output import (
    console,
    escaped,
    print_json,
    print_rows,
    progress_shown,
    write_line,
)

if TYPE_CHECKING:
    from codegen.generated_files.generated_file import BuildReport

app = typer.Typer()
command = partial(app.command, rich_help_panel="Compile")


def name_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files and the command that brings them up to date."""
    for path in stale:
        console(stderr=True).print(
            f"[bold red]stale:[/] {escaped(path)} {reason}; run: linkwright {escaped(command)}"
        )


def refuse_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files as `name_stale` does; exit status 1 if there are any."""
    name_stale(stale, reason, command)
    if stale:
        raise typer.Exit(1)


@command(
    epilog=examples(
        "linkwright build four_bar.py",
        "linkwright build four_bar.py --scene swing --tangents",
        "linkwright build four_bar.py slider_crank.py --check",
    )
)
def build(
    model: ModelFiles, scene: AnyScene = None, settings: Values = None,
    out: Annotated[
        Path | None, output("Folder for the generated files.")
    ] = None,
    tangents: Annotated[
        bool,
        output("Also the exact derivatives that radau5, bdf and auto need, in files of their own; "
               "without this option only existing ones are updated.", "--tangents"),
    ] = False,
    reduced: Annotated[
        bool,
        output("Also the equations in reduced coordinates for simulate --formulation reduced, in "
               "files of their own; without this option only existing ones are updated.",
               "--reduced"),
    ] = False,
    unroll: Annotated[
        Literal["auto", "always", "never"],
        output("Write kernels out, operation by operation: always; never, loops over tables "
               "where something repeats; auto, loops in long kernels.", metavar="WHEN"),
    ] = "auto",
    check: Check = False, as_json: Json = False,
) -> None:  # fmt: skip
    """Compile the scenes of a model, or of several: derive, lower, emit and compile kernels."""
    from codegen.driver import build as run

    options = f"{f' --out {out}' if out else ''}{' --tangents' * tangents}{' --reduced' * reduced}"
    options += f" --unroll {unroll}" * (unroll != "auto")
    values = parameters(settings)
    reports: list[BuildReport] = []
    problems = list[str]()
    for one in model:
        try:
            with progress_shown() as progress:
                report = run(
                    one, scene, out, settings=values, tangents=tangents, reduced=reduced,
                    check=check, unroll=unroll, progress=progress,
                )  # fmt: skip
        except InputError as error:
            if len(model) > 1:
                error.locate(str(one))
            problems += error.problems
            continue
        reports.append(report)
        if not as_json:
            _print_build(report, check)
        name_stale(report.stale, "is missing or out of date", f"build {one}{options}")
    if problems:
        raise InputError(problems)
    stale = [path for report in reports for path in report.stale]
    if as_json:
        scenes = [asdict(scene) for report in reports for scene in report.scenes]
        print_json({"scenes": scenes, "stale": stale})
    if stale:
        raise typer.Exit(1)


def _print_build(report: "BuildReport", check: bool) -> None:
    def state(file: Any) -> str:
        return "checked" if check else "written" if file.changed else "unchanged, nothing written"

    def listed(counts: dict[str, int]) -> str:
        return ", ".join(f"{name} {count}" for name, count in counts.items())

    for s in report.scenes:
        console().print(f"[bold]{s.model}[/], scene [bold]{s.scene}[/]: {state(s)}")
        unknowns = (
            f"{quantity(s.coordinates, 'coordinate')}, {quantity(s.constraints, 'constraint')}"
        )
        rows = [
            ("file", str(s.path)),
            ("bodies", ", ".join(s.bodies)),
            ("equations", f"{unknowns}, {quantity(s.degrees_of_freedom, 'degree of freedom')}"),
            *([("states", ", ".join(s.states))] if s.states else []),
            ("effects", ", ".join(s.effects) or "none"),
            ("left out", ", ".join(s.left_out) or "nothing"),
            ("operations", listed(s.operations)),
        ]
        seconds = dict(s.seconds)
        for companion in s.companions:
            rows.append((companion.title, f"{companion.path}: {state(companion)}"))
            rows.append(("operations", listed(companion.operations)))
            seconds |= {f"{k} {companion.title}": x for k, x in companion.seconds.items()}
        rows.append(("seconds", ", ".join(f"{k} {x:.2f}" for k, x in seconds.items())))
        print_rows([*rows, *(("note", note) for note in s.notes)])


@command(
    epilog=examples(
        "linkwright explain four_bar.py",
        "linkwright explain four_bar.py --scene swing --run 1",
    )
)
def explain(
    model: ModelFile, scene: AnyScene = None, compare: Annotated[
        tuple[str, str] | None, option("Two scenes side by side.", panel="Machine", metavar="A B",
                                       autocompletion=completion.scenes),
    ] = None,
    measure: Annotated[
        bool | None,
        study("Compile the parts of accelerations and time them, some seconds a scene; the "
              "default for one scene or a comparison."),
    ] = None,
    run: Annotated[
        float | None,
        study("Also run the scene for this many seconds; its time is shared among the parts."),
    ] = None,
    kernels: Annotated[
        bool, output("Also the operations of every kernel, a wide table.", "--kernels")
    ] = False,
    out: Annotated[
        Path | None, output("A picture, .png or .svg, or a page, .html.")
    ] = None,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Explain a scene: the parts compiled into it or left out, why, and the cost of each."""
    from codegen.explain.ledger import compare as compare_ledgers
    from codegen.explain.ledger import explain as ledgers_of
    from codegen.explain.picture import write
    from codegen.explain.terminal_table import show

    if scene is not None and compare is not None:
        raise SceneError(
            f"--scene {scene} beside --compare {' '.join(compare)}: give the one or the other."
        )
    timed = (scene or compare) is not None if measure is None else measure
    with progress_shown("reading") as progress:
        ledgers = tuple(
            ledger
            for name in compare or (scene,)
            for ledger in ledgers_of(model, name, measure=timed, t_end=run, progress=progress)
        )
        differences = compare_ledgers(*ledgers) if compare else []
    if as_json:
        facts: dict[str, Any] = {"scenes": [asdict(ledger) for ledger in ledgers]}
        if compare:
            facts["differences"] = [asdict(row) for row in differences]
        print_json(facts)
    else:
        show(ledgers, differences, kernels=kernels)
    if out is not None:
        write_line(f"saved {write(ledgers, out)}")


@command(epilog=examples("linkwright precompile", "linkwright precompile dop853 radau5"))
def precompile(
    methods: Annotated[
        list[str] | None,
        typer.Argument(help="Integration methods; all unless given.", metavar="METHOD",
                       autocompletion=completion.methods),
    ] = None,
) -> None:  # fmt: skip
    """Compile the runtime ahead of the first run, in several processes: a line for each part."""
    from runtime.precompile import precompile as compile_ahead

    compile_ahead(*(methods or ()), told=typer.echo)


@command(epilog=examples("linkwright methods --check"))
def methods(
    out: Annotated[Path | None, output("Folder; the runtime's own by default.")] = None,
    check: Check = False,
) -> None:
    """Write the explicit integration methods of the runtime from their tableaus."""
    from codegen.generated_files.generated_file import write_methods

    written, stale = write_methods(out, check=check)
    if check:
        refuse_stale(stale, "is missing, or not what its tableau gives", "methods")
    console().print(
        f"{len(written)} methods in {escaped(written[0].parent)}, {len(stale)} of them written"
    )
