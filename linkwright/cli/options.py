"""Arguments and options that several commands share, in the panels of their help."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from codegen.errors import InputError, ParameterError
from codegen.files.library_folders import model_names
from linkwright.cli import completion


def examples(*lines: str) -> str:
    """Command lines that stand below the help of a command, and run as they stand.

    They do so in a folder with `four_bar.py`, which `linkwright new four_bar` writes, unless they
    name a model of the library.
    """
    return "\n\n".join(("Examples:", *lines))


def option(text: str, *names: str, panel: str | None = None, **more: Any) -> Any:
    """An option of a command, with its help and the panel of the help where it stands."""
    return typer.Option(*names, help=text, rich_help_panel=panel, **more)


machine, time, study, integration, picture, output = (
    partial(option, panel=panel)
    for panel in ("Machine", "Time", "Study", "Integration", "Picture", "Output")
)
scene = partial(machine, metavar="SCENE", autocompletion=completion.scenes)
pair = partial(machine, metavar="NAME=VALUE", autocompletion=completion.coordinates)
series = partial(option, metavar="SERIES", autocompletion=completion.quantities)
method = partial(integration, metavar="METHOD", autocompletion=completion.methods)
formulation = partial(integration, metavar="FORM", autocompletion=completion.formulations)


def only_model() -> str:
    """The model file of the working folder where there is one alone; InputError otherwise."""
    here = Path.cwd()
    local = model_names(here)
    if len(local) == 1 and here.name != "models":
        return f"{local[0]}.py"
    if not local:
        raise InputError(
            "no model is given, and this folder has none. Give the path of a model file or the "
            "name of a model, or write one to start from: linkwright new NAME."
        )
    some = ", ".join(f"{name}.py" for name in local[:8]) + (", ..." if len(local) > 8 else "")
    raise InputError(f"no model is given, and this folder has several: {some}. Give one of them.")


def given_or_only(context: typer.Context, model: Any) -> Any:
    """The models that are given, or the only one of the working folder."""
    if model or context.resilient_parsing:
        return model
    return [only_model()] if isinstance(model, list) else only_model()


FILE = "Path of a model file, or a name: models/NAME.py."
model = partial(
    typer.Argument,
    metavar="MODEL",
    show_default="the only one of the folder",
    callback=given_or_only,
    autocompletion=completion.models,
)
ModelFile = Annotated[str, model(help=FILE, default_factory=str)]
ModelFiles = Annotated[list[str], model(help=f"{FILE} One or several.", default_factory=list)]
Scene = Annotated[str | None, scene("Scene of the model; the first unless given.")]
AnyScene = Annotated[str | None, scene("One scene; all unless given.")]
Values = Annotated[
    list[str] | None,
    pair("A parameter, in its declared unit; again for more.", "--set",
         autocompletion=completion.settings),
]  # fmt: skip
Generated = Annotated[
    Path | None, machine("Folder of the generated modules, as --out of build names it.")
]
MotionStart = Annotated[float, time("First instant in s; the start values belong to it.")]
TEnd = Annotated[float, time("Last instant in s.")]
OptionalTEnd = Annotated[float | None, time("Last instant in s.")]
Points = Annotated[
    int | None, time("Number of output instants, ends included; 501 unless given.", min=2)
]
Analysis = Annotated[
    str | None,
    study("simulate, kinematics, inverse-dynamics or equilibrium (which needs no --t-end); "
          "follows from the scene unless given.", autocompletion=completion.analyses),
]  # fmt: skip
Check = Annotated[bool, output("Write nothing; fail if a file is out of date.", "--check")]
Json = Annotated[bool, output("Print one JSON object on stdout.", "--json")]


def assigned(option: str, texts: list[str] | None, problems: list[str]) -> dict[str, float]:
    """The values of an option that takes NAME=VALUE; what is wrong joins the problems."""
    values = dict[str, float]()
    for text in texts or ():
        name, _, value = text.partition("=")
        name = name.strip()
        if name in values:
            problems.append(f"{option} {name} is given twice; give one value.")
        try:
            values[name] = float(value)  # "" where there is no =
        except ValueError:
            problems.append(f"{option} {text}: write NAME=VALUE with a number.")
    return values


def parameters(settings: list[str] | None) -> dict[str, float]:
    """The values of --set; ParameterError with all that is wrong."""
    problems = list[str]()
    values = assigned("--set", settings, problems)
    if problems:
        raise ParameterError(problems)
    return values
