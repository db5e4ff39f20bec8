"""How `linkwright` presents the parameters of its commands: panel, placeholder, completion.

The commands of the compiler and of the runtime state what a parameter means; what it looks like
here follows from its name, so that the same option looks the same in every command.
"""

import inspect
import os
from collections.abc import Callable
from copy import copy
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from typer.models import ArgumentInfo, OptionInfo

from codegen.errors import InputError
from codegen.files.library_folders import model_names
from linkwright import shell_completion

MACHINE, TIME, INTEGRATION, STUDY, OUTPUT = "Machine", "Time", "Integration", "Study", "Output"
PICTURE = "Picture"
PANELS = (MACHINE, TIME, STUDY, INTEGRATION, PICTURE, OUTPUT)
"""Panels of options in the order of a page of help; the other options stand above them."""


class Look(NamedTuple):
    """The panel of an option, its placeholder, and the function that completes its value."""

    panel: str | None = None
    placeholder: str | None = None
    completion: Callable[..., Any] | None = None


_NUMBER, _NAME = "NUMBER", "NAME"
_VALUE = "NAME=VALUE"
LOOKS = {
    "model": Look(None, "MODEL", shell_completion.models),
    "scene": Look(MACHINE, "SCENE", shell_completion.scenes),
    "compare": Look(MACHINE, "A B", shell_completion.scenes),
    "beside": Look(MACHINE, "SCENE", shell_completion.scenes),
    "settings": Look(MACHINE, _VALUE, shell_completion.settings),
    "start": Look(MACHINE, _VALUE, shell_completion.coordinates),
    "guess": Look(MACHINE, _VALUE, shell_completion.coordinates),
    "generated": Look(MACHINE, "FOLDER"),
    "t": Look(TIME, "SECONDS"),
    "t_start": Look(TIME, "SECONDS"),
    "t_end": Look(TIME, "SECONDS"),
    "points": Look(TIME, "COUNT"),
    "until": Look(TIME, "CONDITION"),
    "quantity": Look(STUDY, "SERIES", shell_completion.quantities),
    "error": Look(STUDY, _NUMBER),
    "analysis": Look(STUDY, "ANALYSIS"),
    "fidelities": Look(STUDY),
    "rounds": Look(STUDY, "COUNT"),
    "reference": Look(STUDY, "FILE"),
    "modelling": Look(STUDY),
    "building": Look(STUDY),
    "quick": Look(STUDY),
    "limit": Look(STUDY, "SECONDS"),
    "over": Look(STUDY, "NAME=VALUES", shell_completion.settings),
    "sample": Look(STUDY, "SAMPLE"),
    "count": Look(STUDY, "COUNT"),
    "seed": Look(STUDY, "SEED"),
    "workers": Look(STUDY, "COUNT"),
    "scheduler": Look(STUDY, "ADDRESS"),
    "measure": Look(STUDY),
    "run": Look(STUDY, "SECONDS"),
    "accuracy": Look(INTEGRATION, _NUMBER),
    "method": Look(INTEGRATION, "METHOD", shell_completion.methods),
    "rtol": Look(INTEGRATION, _NUMBER),
    "atol": Look(INTEGRATION, _NUMBER),
    "correction": Look(INTEGRATION, "WAY", shell_completion.corrections),
    "time_scale": Look(INTEGRATION, "SECONDS"),
    "formulation": Look(INTEGRATION, "FORM", shell_completion.formulations),
    "first_step": Look(INTEGRATION, "SECONDS"),
    "max_step": Look(INTEGRATION, "SECONDS"),
    "max_steps": Look(INTEGRATION, "COUNT"),
    "dimensions": Look(PICTURE),
    "forces": Look(PICTURE),
    "frames": Look(PICTURE),
    "names": Look(PICTURE),
    "guesses": Look(PICTURE),
    "tangents": Look(OUTPUT),
    "reduced": Look(OUTPUT),
    "kernels": Look(OUTPUT),
    "out": Look(OUTPUT, "PATH"),
    "check": Look(OUTPUT),
    "keep": Look(OUTPUT, "SERIES"),
    "resume": Look(OUTPUT),
    "picture": Look(OUTPUT, "FILE"),
    "as_json": Look(OUTPUT),
    "kind": Look(None, "KIND", shell_completion.kinds),
    "methods": Look(None, "METHOD", shell_completion.methods),
}
"""Parameter of a command → its look."""


def presented(command: Callable[..., Any], options: tuple[str, ...] = ()) -> Callable[..., Any]:
    """The command with the look of its parameters; a missing model is the folder's only one.

    The signature that typer reads is another, and the function that runs is the same. `options`
    names parameters that keep the look that they are declared with.
    """

    @wraps(command)
    def shown(*arguments: Any, **words: Any) -> Any:
        return command(*arguments, **words)

    about = inspect.signature(command)
    looks = {name: look for name, look in LOOKS.items() if name not in options}
    if "accuracy" in about.parameters:  # of a run, which the quantities belong to
        looks["quantity"] = looks["quantity"]._replace(panel=INTEGRATION)
    parameters = [
        p.replace(annotation=_dressed(p.annotation, looks.get(p.name), p.name == "model"))
        for p in about.parameters.values()
    ]
    # Typer shows panels in the order of their first options.
    places = {panel: place for place, panel in enumerate((None, *PANELS))}
    ordered = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    ordered.sort(key=lambda p: places.get(_panel(p.annotation), len(places)))
    shown.__signature__ = about.replace(parameters=ordered)  # type: ignore[attr-defined]
    shown.__annotations__ = {p.name: p.annotation for p in ordered} | {"return": None}
    return shown


def only_model() -> str:
    """The model file of the working folder where there is one alone; InputError otherwise."""
    if "_LINKWRIGHT_COMPLETE" in os.environ:  # a shell asks for words, and nothing runs
        return ""
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


def _dressed(annotation: Any, look: Look | None, is_model: bool) -> Any:
    """The annotation of a parameter with its look."""
    if look is None or get_origin(annotation) is not Annotated:
        return annotation
    kind, *notes = get_args(annotation)
    dressed = [copy(note) for note in notes]
    for note in dressed:
        if not isinstance(note, ArgumentInfo | OptionInfo):
            continue
        note.metavar = note.metavar or look.placeholder
        head = f"{look.placeholder}: "
        if note.help and note.help.startswith(head):
            rest = note.help.removeprefix(head)
            note.help = rest[:1].upper() + rest[1:]
        note.autocompletion = note.autocompletion or look.completion
        if isinstance(note, OptionInfo):
            note.rich_help_panel = look.panel
        elif is_model and note.default is ...:
            several = get_origin(kind) is list
            note.default_factory = (lambda: [only_model()]) if several else only_model
            note.show_default = "the only one of the folder"
    return Annotated[kind, *dressed]


def _panel(annotation: Any) -> str | None:
    """The panel of a dressed option."""
    notes = get_args(annotation)[1:] if get_origin(annotation) is Annotated else ()
    return next((note.rich_help_panel for note in notes if isinstance(note, OptionInfo)), None)
