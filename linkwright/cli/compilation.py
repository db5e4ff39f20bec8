"""Commands of the compiler: build, explain, precompile, methods."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import typer

from codegen.errors import InputError, SceneError
from linkwright.cli import completion
from linkwright.cli.options import (
    AnyScene,
    Check,
    Json,
    ModelFile,
    ModelFiles,
    Values,
    commands,
    option,
    output,
    parameters,
    study,
)
from linkwright.cli.output import (
    bold,
    print_json,
    print_rows,
    progress_shown,
    sizes,
    write_error,
    write_line,
)

if TYPE_CHECKING:
    from codegen.generated_files.generated_file import BuildReport

app = typer.Typer()
command = commands(app, "Compile")


def name_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files and the command that brings them up to date."""
    for path in stale:
        write_error(f"{path} {reason}; run: linkwright {command}", "stale:")


def refuse_stale(stale: Sequence[Path], reason: str, command: str) -> None:
    """Name the stale files; exit status 1 if there are any."""
    name_stale(stale, reason, command)
    if stale:
        raise typer.Exit(1)


@command(
    "linkwright build four_bar.py",
    "linkwright build four_bar.py --scene swing --tangents",
    "linkwright build four_bar.py slider_crank.py --check",
)
def build(
    model: ModelFiles, scene: AnyScene = None, settings: Values = None,
    out: Path | None = output(None, "Folder for the generated files."),
    tangents: bool = output(
        False, "Also the exact derivatives that radau5, bdf and auto need, in files of their own; "
        "without this option only existing ones are updated.", "--tangents"
    ),
    reduced: bool = output(
        False,
        "Also the equations in reduced coordinates for simulate --formulation reduced, in files "
        "of their own; without this option only existing ones are updated.", "--reduced"
    ),
    unroll: Literal["auto", "always", "never"] = output(
        "auto", "When to write kernels out operation by operation: always, never (loops where "
        "operations repeat) or auto (loops in long kernels).", metavar="WHEN"
    ),
    check: Check = False, as_json: Json = False,
) -> None:  # fmt: skip
    """Compile the scenes of a model, or of several: derive, lower, emit and compile kernels."""
    from codegen.driver import build as run

    options = f"{f' --out {out}' if out else ''}{' --tangents' * tangents}{' --reduced' * reduced}"
    options += f" --unroll {unroll}" * (unroll != "auto")
    values, problems = parameters(settings), list[str]()
    scenes, stale = list[dict[str, Any]](), list[Path]()
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
        scenes += (asdict(one, dict_factory=_without_text) for one in report.scenes)
        stale += report.stale
        if not as_json:
            _print_build(report, check)
        name_stale(report.stale, "is missing or out of date", f"build {one}{options}")
    if problems:
        raise InputError(problems)
    if as_json:
        print_json({"scenes": scenes, "stale": stale})
    if stale:
        raise typer.Exit(1)


def _without_text(fields: list[tuple[str, Any]]) -> dict[str, Any]:
    return {name: value for name, value in fields if name != "text"}


def _print_build(report: "BuildReport", check: bool) -> None:
    def state(file: Any) -> str:
        return "checked" if check else "written" if file.changed else "unchanged, nothing written"

    def listed(counts: dict[str, int]) -> str:
        return ", ".join(f"{name} {count}" for name, count in counts.items())

    for s in report.scenes:
        typer.echo(f"{bold(s.model)}, scene {bold(s.scene)}: {state(s)}")
        rows = [
            ("file", str(s.path)),
            ("bodies", ", ".join(s.bodies)),
            ("equations", sizes(s)),
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
        rows += [("assembly", s.problem)] if s.problem else []
        print_rows([*rows, *(("note", note) for note in s.notes)])


@command("linkwright explain four_bar.py", "linkwright explain four_bar.py --scene swing --run 1")
def explain(
    model: ModelFile, scene: AnyScene = None, compare: tuple[str, str] | None = option(
        None, "Two scenes side by side.",
        panel="Machine", metavar="A B", autocompletion=completion.scenes
    ),
    measure: bool | None = study(
        None,
        "Compile and time the parts of accelerations, some seconds for each scene; the default "
        "for one scene or a comparison."
    ),
    run: float | None = study(
        None, "Also run the scene for this many seconds; the parts share the time of the run."
    ),
    kernels: bool = output(
        False, "Also the operations of every kernel, a wide table.", "--kernels"
    ),
    out: Path | None = output(None, "A picture, .png or .svg, or a page, .html."),
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


@command("linkwright precompile", "linkwright precompile dop853 radau5")
def precompile(
    methods: list[str] | None = typer.Argument(
        None, help="Integration methods; all unless given.", metavar="METHOD",
        autocompletion=completion.methods,
    ),
) -> None:  # fmt: skip
    """Compile the runtime ahead of the first run, in several processes: a line for each part."""
    from runtime.precompile import precompile as compile_ahead

    compile_ahead(*(methods or ()), told=typer.echo)


@command("linkwright methods --check")
def methods(
    out: Path | None = output(None, "Folder; the runtime's own by default."), check: Check = False
) -> None:
    """Write the explicit integration methods of the runtime from their tableaus."""
    from codegen.generated_files.generated_file import write_methods

    written, stale = write_methods(out, check=check)
    if check:
        refuse_stale(stale, "is missing, or not what its tableau gives", "methods")
    typer.echo(f"{len(written)} methods in {written[0].parent}, {len(stale)} of them written")
