"""The command line: ``python -m codegen build``, ``explain``, ``elements`` and ``methods``."""

import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from enum import Enum
from functools import cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from codegen.emit.line_wrapping import quantity
from codegen.errors import InputError, ParameterError, SceneError
from codegen.termination_signals import finish

if TYPE_CHECKING:
    from rich.console import Console

    from codegen.generated_files.build_report import BuildReport

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Compile a declared mechanism to numba kernels.",
)


@cache
def console(*, stderr: bool = False) -> "Console":
    """The stream of results, or of messages; Rich takes a fifth of a start of the program."""
    from rich.console import Console

    return Console(stderr=stderr, soft_wrap=True, highlight=False)


def escaped(text: str) -> str:
    """Text in which square brackets are no marks of a style."""
    from rich.markup import escape

    return escape(text)


def option(text: str, *names: str, **more: Any) -> Any:
    """An option of a command, with its help."""
    return typer.Option(*names, help=text, **more)


class Unroll(Enum):
    """Whether kernels are written out."""

    AUTO = "auto"
    ALWAYS = "always"
    NEVER = "never"


ModelArgument = Annotated[
    str, typer.Argument(help="Path of a model file, or a name: models/NAME.py.")
]
SceneOption = Annotated[str | None, option("One scene; all by default.")]
CheckOption = Annotated[bool, option("Write nothing; fail if a file is out of date.", "--check")]
JsonOption = Annotated[bool, option("One JSON object on stdout.", "--json")]


def answers_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Report wrong input: every problem on a line of stderr, and exit status 2."""

    @wraps(command)
    def guarded(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except InputError as error:
            for problem in error.problems:
                console(stderr=True).print(f"[bold red]error:[/] {escaped(problem)}")
            if options.get("as_json"):
                answer = {"ok": False, "status": 2, "problems": error.problems}
                typer.echo(json.dumps(answer))
            raise typer.Exit(2) from None

    return guarded


def name_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files and the command that brings them up to date."""
    for path in stale:
        console(stderr=True).print(
            f"[bold red]stale:[/] {escaped(str(path))} {reason}; run: linkwright {escaped(command)}"
        )


def refuse_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files as `name_stale` does; exit status 1 if there are any."""
    name_stale(stale, reason, command)
    if stale:
        raise typer.Exit(1)


@contextmanager
def progress_shown(first: str = "starting") -> Iterator[Callable[[str], None]]:
    """A line in the terminal that says what is going on: what is yielded changes it."""
    with console(stderr=True).status(first, spinner="dots") as status:
        yield lambda message: status.update(escaped(message))


def parse_settings(settings: list[str]) -> dict[str, float]:
    """``NAME=VALUE`` pairs of ``--set``."""
    values, problems = dict[str, float](), list[str]()
    for setting in settings:
        name, _, value = setting.partition("=")
        name = name.strip()
        if name in values:
            problems.append(f"--set {name} is given twice; give one value.")
        try:
            values[name] = float(value)  # "" where there is no =
        except ValueError:
            problems.append(f"--set {setting!r}: write NAME=VALUE with a number, like J1=900.")
    if problems:
        raise ParameterError(problems)
    return values


@app.command()
@answers_errors
def build(
    model: Annotated[
        list[str],
        typer.Argument(help="Paths of model files, or names: models/NAME.py; one or several."),
    ],
    scene: SceneOption = None,
    settings: Annotated[
        list[str] | None, option("NAME=VALUE: another default; repeatable.", "--set")
    ] = None,
    out: Annotated[Path | None, option("Folder for the generated files.")] = None,
    tangents: Annotated[
        bool,
        option("Also the exact derivatives that radau5, bdf and auto need, in files of their own; "
               "without this option only existing ones are updated.", "--tangents"),
    ] = False,
    reduced: Annotated[
        bool,
        option("Also the equations in reduced coordinates for simulate --formulation reduced, in "
               "files of their own; without this option only existing ones are updated.",
               "--reduced"),
    ] = False,
    unroll: Annotated[
        Unroll,
        option("Write kernels out, operation by operation: always; never, loops over tables "
               "where something repeats; auto, loops in long kernels.", metavar="WHEN"),
    ] = Unroll.AUTO,
    check: CheckOption = False, as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Derive, lower, emit and compile the kernels of the scenes of a model, or of several."""
    from codegen.driver import build as run

    options = f"{f' --out {out}' if out else ''}{' --tangents' * tangents}{' --reduced' * reduced}"
    options += f" --unroll {unroll.value}" if unroll is not Unroll.AUTO else ""
    values = parse_settings(settings or [])
    reports: list[BuildReport] = []
    problems = list[str]()
    for one in model:
        try:
            with progress_shown() as progress:
                report = run(
                    one, scene, out, settings=values, tangents=tangents, reduced=reduced,
                    check=check, unroll=unroll.value, progress=progress,
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
        scenes = [asdict(s) for report in reports for s in report.scenes]
        typer.echo(json.dumps({"scenes": scenes, "stale": stale}, default=str))
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
        for title, text in (*rows, *(("note", note) for note in s.notes)):
            console().print(f"  {title:<13} {escaped(text)}")


@app.command()
@answers_errors
def explain(
    model: ModelArgument, scene: SceneOption = None,
    compare: Annotated[
        tuple[str, str] | None, option("Two scenes side by side.", metavar="A B")
    ] = None,
    measure: Annotated[
        bool | None,
        option("Compile the parts of accelerations and time them, some seconds a scene; the "
               "default for one scene or a comparison."),
    ] = None,
    run: Annotated[
        float | None,
        option("Also run the scene for this many seconds; its time is shared among the parts."),
    ] = None,
    kernels: Annotated[
        bool, option("Also the operations of every kernel, a wide table.", "--kernels")
    ] = False,
    out: Annotated[Path | None, option("A picture, .png or .svg, or a page, .html.")] = None,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Explain a scene: the parts compiled into it or left out, why, and the cost of each."""
    from codegen.explain.ledger import explain as ledgers_of
    from codegen.explain.ledger_records import compare as compare_ledgers
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
        comparison = compare_ledgers(*ledgers) if compare else None
    show(ledgers, comparison, kernels=kernels, as_json=as_json)
    if out is not None:
        console(stderr=True).print(f"saved {escaped(str(write(ledgers, out)))}")


@app.command()
@answers_errors
def elements(
    kind: Annotated[
        list[str] | None,
        typer.Argument(
            help="A kind of element, with spaces, hyphens or underscores between its words; "
            "without it, all are listed."
        ),
    ] = None,
    model: Annotated[str | None, option("A model file with your own elements.")] = None,
    out: Annotated[Path | None, option("Folder to write the pages into, as docs/elements.")] = None,
    check: CheckOption = False,
) -> None:
    """Joints, drivers and forces: a list, the page of one kind, or all pages as files."""
    from codegen.reading.model_file import read_model
    from codegen.reference.pages import chosen_kinds, find_kind, page, write

    declared = read_model(model).model if model else None
    only = find_kind(" ".join(kind)) if kind else None
    folder = out or (Path("docs/elements") if check else None)
    if folder is None and only is None:
        from rich.console import Console
        from rich.table import Table

        from codegen.explain.terminal_table import PAPER

        table = Table("kind", "role", "summary")
        for name, registered in chosen_kinds(declared).items():
            table.add_row(name, registered.role, escaped(registered.summary))
        Console(width=PAPER, highlight=False).print(table)
    elif only is not None and folder is None:
        typer.echo(page(only, declared), nl=False)
    elif folder is not None:
        written = write(folder, declared, only, check=check)
        if check:
            reason = "is missing, out of date, or of no kind"
            refuse_stale(written.stale, reason, f"elements --out {folder}")
        changed = len(written.stale)
        console().print(
            f"{len(written.paths)} pages in {escaped(str(folder))}, {changed} of them written"
        )


@app.command()
@answers_errors
def methods(
    out: Annotated[Path | None, option("Folder; the runtime's own by default.")] = None,
    check: CheckOption = False,
) -> None:
    """Write the explicit integration methods of the runtime from their tableaus."""
    from codegen.generated_files.runge_kutta_modules import write_methods

    written, stale = write_methods(out, check=check)
    if check:
        refuse_stale(stale, "is missing, or not what its tableau gives", "methods")
    console().print(
        f"{len(written)} methods in {escaped(str(written[0].parent))}, {len(stale)} of them written"
    )


def main() -> None:
    """Entry point."""
    warnings.formatwarning = lambda message, *_, **__: f"note: {message}\n"
    try:
        app(prog_name="python -m codegen")
    finally:
        finish()
