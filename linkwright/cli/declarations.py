"""Commands about declarations: new, list, elements, check, draw."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from codegen.errors import GeneratedFileError, InputError
from codegen.object_display import counted
from codegen.readers.values import name_problem, nearest
from linkwright.cli import completion
from linkwright.cli.compilation import refuse_stale
from linkwright.cli.options import (
    AnyScene,
    Check,
    Generated,
    Json,
    ModelFile,
    Scene,
    Values,
    commands,
    option,
    output,
    parameters,
    picture,
    time,
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
    from codegen.explain.declaration_report import DeclarationReport, SceneFacts

app = typer.Typer()
command = commands(app, "Declare")
KINDS = completion.MODELS_TO_START_FROM
_MOVED = 3  # layout: coordinates that are listed
_SINGULAR = {"bodies": "body", "parameters": "parameter"}


@command("linkwright new four_bar", "linkwright new press --kind slider-crank")
def new(
    name: str = typer.Argument(help="Name of the model and its file NAME.py.", metavar="NAME"),
    kind: str = option(
        "four-bar", f"Machine to start from: {', '.join(KINDS)}.", metavar="KIND",
        autocompletion=completion.models_to_start_from,
    ),
) -> None:  # fmt: skip
    """Write a commented model to start from into the working folder; it overwrites nothing."""
    stem, kind = name.removesuffix(".py"), kind.replace("_", "-")
    if kind not in KINDS:
        raise InputError(
            f"there is no model to start from of kind {kind!r}; {nearest(kind, KINDS)}"
        )
    if problem := name_problem("model", stem):
        raise InputError(problem)
    path, text = Path(f"{stem}.py"), template(kind).replace("NAME", stem)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(
            f"{path} is there already, and stays as it is; give another name, or delete it first."
        ) from None
    except OSError as error:
        raise GeneratedFileError(f"{path} cannot be written: {error.strerror or error}.") from error
    typer.echo(f"{path}: a {kind} to start from. Next:")
    for line in text.splitlines():
        if line.startswith("    linkwright "):
            typer.echo(line[2:])


def template(kind: str) -> str:
    """The text of a model to start from, with NAME where its name stands."""
    path = Path(__file__).parents[1] / "templates" / f"{kind.replace('-', '_')}.py"
    return path.read_text(encoding="utf-8")


@command("linkwright list", "linkwright list .", name="list")
def list_models(
    folder: Path | None = typer.Argument(
        None, help="A folder of model files; without it this folder, its models/ and the library."
    ),
    as_json: Json = False,
) -> None:
    """List models and their scenes, each with a line from its docstring."""
    from linkwright.cli.model_listing import facts, found_models, show

    found = found_models(folder)
    if as_json:
        print_json(facts(found))
    else:
        show(found)


@command(
    "linkwright elements", "linkwright elements revolute", "linkwright elements one-way-clutch"
)
def elements(
    kind: list[str] | None = typer.Argument(
        None, metavar="KIND", autocompletion=completion.kinds,
        help="A kind of element, with spaces, hyphens or underscores between its words; without "
        "it, all are listed.",
    ),
    model: str | None = option(
        None, "A model file with your own elements.", metavar="MODEL",
        autocompletion=completion.models,
    ),
    out: Path | None = output(None, "Folder to write the pages into, as docs/elements."),
    check: Check = False,
) -> None:  # fmt: skip
    """List joints, drivers and forces, show the page of one, or write all pages as files."""
    from codegen.reading.model_file import read_model
    from codegen.reference.pages import chosen_kinds, find_kind, page, write

    declared = read_model(model).model if model else None
    only = find_kind(" ".join(kind)) if kind else None
    folder = out or (Path("docs/elements") if check else None)
    if folder is not None:
        written = write(folder, declared, only, check=check)
        if check:
            reason = "is missing, out of date, or of no kind"
            refuse_stale(written.stale, reason, f"elements --out {folder}")
        changed = len(written.stale)
        typer.echo(f"{len(written.paths)} pages in {folder}, {changed} of them written")
    elif only is not None:
        typer.echo(page(only, declared), nl=False)
    else:
        from rich.console import Console
        from rich.table import Table
        from rich.text import Text

        from codegen.explain.terminal_table import PAPER

        for title, space in ((None, False), ("In space, with equations of their own", True)):
            table = Table("kind", "role", "summary", title=title, title_justify="left")
            for name, registered in chosen_kinds(declared, space=space).items():
                table.add_row(name, registered.role, Text(registered.summary))
            Console(width=PAPER, highlight=False).print(table)


@command("linkwright check four_bar.py", "linkwright check four_bar.py --scene driven --json")
def check(
    model: ModelFile, scene: AnyScene = None, settings: Values = None, as_json: Json = False
) -> None:
    """Find everything that is wrong with a declaration.

    If nothing is wrong, show freedoms, redundant constraints and the start, assembled as for a run.
    The exit status is 2 if something is wrong.
    """
    from codegen.explain.declaration_report import check_declaration

    values = parameters(settings)
    with progress_shown() as progress:
        report = check_declaration(model, scene, settings=values, progress=progress)
    for problem in report.problems:
        write_error(problem)
    if as_json:
        print_json(report.facts())
    else:
        _show_declaration(report, model)
    if report.problems:
        raise typer.Exit(2)


def _show_declaration(report: "DeclarationReport", model: str) -> None:
    """Print the facts of the sound scenes, and what no scene uses."""
    for scene in report.scenes:
        if not scene.problem:
            typer.echo(f"{bold(report.model)}, scene {bold(scene.scene)}: sound")
            print_rows(_rows(scene))
    for kind, names in report.unused.items():
        word = kind if len(names) > 1 else _SINGULAR.get(kind, kind.removesuffix("s"))
        typer.echo(f"No scene uses {word} {', '.join(names)}.")
    if not report.problems and report.scenes:
        typer.echo(f"Next: linkwright {_next_command(report.scenes[0], model)}")


def _rows(scene: "SceneFacts") -> list[tuple[str, str]]:
    """Titles and texts of a scene."""
    independent = scene.degrees_of_freedom == scene.coordinates - scene.constraints
    redundant = "none" if independent else "some"
    ends = [f"{body} ({joint})" for body, joint in scene.one_joint.items()]
    unused, left_out = scene.unused_parameters, [*scene.left_out]
    parameters = [f"parameter{'s' * (len(unused) > 1)} {', '.join(unused)}"] if unused else []
    found = {
        "bodies": ", ".join(scene.bodies),
        "equations": f"{sizes(scene)}; {redundant} redundant",
        "mobility": "{} by Grübler's count, {} by the rank of Φ_q".format(*scene.mobility),
        "four-bar": "; ".join(scene.four_bars),
        "assembly": _assembly(scene),
        "one joint": ", ".join(ends) if scene.degrees_of_freedom else "",
        "left out": "; ".join([*([", ".join(left_out)] if left_out else []), *parameters]),
    }
    rows = [(title, text) for title, text in found.items() if text or title == "bodies"]
    return [*rows, *(("note", note) for note in scene.notes)]


def _assembly(scene: "SceneFacts") -> str:
    """`the joints close, within 2e-16, and move 3 coordinates: rod.x 0.15 → 0.145 m`."""
    if not scene.constraints:
        return "there are no joints to close"
    text = f"the joints close at t = 0, within {scene.gap:.1e} m or rad"
    if not scene.moved:
        return f"{text}, where the scene puts the bodies"
    moved = [f"{one.name} {one.guess:.4g} → {one.reached:.4g} {one.unit}" for one in scene.moved]
    more = len(moved) - _MOVED
    return (
        f"{text}; this moves {counted(len(moved), 'coordinate')}: "
        f"{', '.join(one.removesuffix(' 1') for one in moved[:_MOVED])}"
        f"{f', and {more} more' if more > 0 else ''}"
    )


def _next_command(scene: "SceneFacts", model: str) -> str:
    """The command that fits a scene."""
    if scene.analysis == "equilibrium":
        return f"equilibrium {model} --scene {scene.scene}"
    command = "inverse" if scene.drivers and not scene.degrees_of_freedom else "simulate"
    command = "kinematics" if scene.analysis == "kinematics" else command
    return f"{command} {model} --scene {scene.scene} --t-end 1"


@command(
    "linkwright draw four_bar.py --out four_bar.png",
    "linkwright draw four_bar.py --scene driven --t 0.25 --forces --out quarter.svg",
)
def draw(
    model: ModelFile,
    out: Path = output(..., "The picture to write: .png, .svg or .pdf."),
    scene: Scene = None,
    t: float | None = time(
        None,
        "Instant in s at which the machine is assembled; without it the start is drawn, and "
        "nothing is built."
    ),
    settings: Values = None,
    generated: Generated = None,
    dimensions: bool = picture(
        False, "Also distances between the points of a body, m.", "--dimensions"
    ),
    forces: bool = picture(False, "Also the applied forces, to scale.", "--forces"),
    frames: bool = picture(False, "Also frames and centres of mass.", "--frames"),
    names: bool = picture(True, "Names of bodies and joints, or none."),
    guesses: bool = picture(
        False, "Draw the bodies at their guesses, with the gap of each joint.", "--guesses"
    ),
    view: str = picture("usual", "In space along an axis: x, y, z, -x, -y or -z."),
    as_json: Json = False,
) -> None:  # fmt: skip
    """Draw a machine as it is declared, at its start or at an instant, into a file."""
    from codegen.presentation import check_picture, in_pyplot, save_picture

    check_picture(out)
    if guesses and t is not None:
        raise InputError("--guesses with --t: at an instant joints are closed; leave one out.")
    wanted: dict[str, Any] = {
        "parameters": parameters(settings), "dimensions": dimensions, "forces": forces,
        "frames": frames, "names": names, "view": view,
    }  # fmt: skip
    with progress_shown("drawing"), in_pyplot(False):
        if t is None:
            from codegen.reading.model_file import read_model

            figure = read_model(model).model.draw(scene, assembled=not guesses, **wanted)
        else:
            from runtime.machine_loading import load

            figure = load(model, scene, generated=generated).draw(t, **wanted)
        save_picture(figure, out)
    write_line(f"Saved: {out}")
    if as_json:
        print_json({"ok": True, "saved": str(out)})
