"""A case file in place of MODEL: it says what the options of a command do not."""

from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from codegen.errors import InputError

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.cases.case import Case
    from runtime.machine_facade import Machine

_ENDINGS = (".yaml", ".yml", ".json")
_OTHER_MEANING = {
    "accuracy": {"method", "formulation", "rtol", "accuracy", "points"},
    "matters": {"accuracy", "quantity", "points"},
    "sweep": {"quantity"},
}
"""Options of a study that are no word of a run, though they have its name."""


class _InForce(NamedTuple):
    """The case of a command, and the command's context."""

    case: "Case"
    context: typer.Context


_in_force: ContextVar[_InForce | None] = ContextVar("case of the command", default=None)


def read_case(context: typer.Context, model: str | None) -> str | None:
    """Let a case that is named in place of a model say the options that are not given."""
    _in_force.set(None)
    if model is None or not model.lower().endswith(_ENDINGS) or context.resilient_parsing:
        return model
    from runtime.cases.case import load_case
    from runtime.cli.common import exit_on_error

    with exit_on_error(as_json=False):
        case = load_case(model)
        context.default_map = {**(context.default_map or {}), **_options(case, context)}
        _in_force.set(_InForce(case, context))
    return model


def _options(case: "Case", context: typer.Context) -> dict[str, Any]:
    """The words of a case by the names of the options that they stand for."""
    from runtime.cases.machine_values import SECONDS_WORDS, seconds
    from runtime.core.analysis_names import ANALYSES, analysis_name

    command = context.info_name or ""
    analysis = analysis_name(command)
    if analysis in ANALYSES and analysis != case.analysis:
        asked = case.analysis.replace("_", "-")
        raise InputError(
            f"{case.path}: the case asks for {asked}, and the command is {command}. Run: "
            f"linkwright {asked} {case.path}"
        )
    words = {k: v for k, v in case.run.items() if k != "until"}
    words |= {name: seconds(words[name]) for name in words.keys() & SECONDS_WORDS}
    if type(instants := words.pop("t_eval", None)) is int:
        words["points"] = instants
    if "quantities" in words:
        words["quantity"] = words.pop("quantities")
    if isinstance(case.scene, str):
        words["scene"] = case.scene
    if case.analysis != ANALYSES[0]:
        words["analysis"] = case.analysis.replace("_", "-")  # of studies
    if command == "sweep" and case.analysis == "equilibrium":
        if "t" in words:
            words["t_start"] = words.pop("t")
        if "method" in words:
            raise InputError(
                f"{case.path}: a sweep finds equilibria by the usual method; leave run.method out."
            )
    left_out = _OTHER_MEANING.get(command, set())
    return {name: value for name, value in words.items() if name not in left_out}


def case_in_force() -> "Case | None":
    """The case that the running command was given, if any."""
    found = _in_force.get()
    return None if found is None else found.case


def source(model: str, scene: str | None) -> "tuple[str | Model, str | Scene | None]":
    """The model and the scene of a command, as `load` and the studies take them."""
    case = case_in_force()
    if case is None:
        return model, scene
    if scene is not None:
        return case.model_path, scene
    return case.source()


def load_machine(model: str, scene: str | None, generated: Path | None) -> "Machine":
    """The machine of a command."""
    from runtime.machine_loading import load

    case = case_in_force()
    if case is not None and scene is None:
        return case.machine(generated=generated)
    return load(model if case is None else case.model_path, scene, generated=generated)


def values_of_case(machine: "Machine | None" = None) -> dict[str, Any]:
    """Parameters, start, guess, conditions and listed instants of the case; nothing without one.

    `machine` is that of the command; a study has none, and that of the case is loaded for its
    units.
    """
    in_force = _in_force.get()
    if in_force is None:
        return {}
    case, context = in_force
    words = case.words(machine or case.machine())
    origin = context.get_parameter_source("points")
    listed = isinstance(case.run.get("t_eval"), list | str)
    listed = listed and (origin is None or origin.name != "COMMANDLINE")
    if listed and machine is None:
        _refuse_instants(case, context)
        listed = False
    kept = ("parameters", "start", "guess", "until", *(("t_eval",) if listed else ()))
    found = {name: words[name] for name in kept if name in words}
    for text in context.params.get("over") or ():  # what a sweep varies
        for values in found.keys() & {"parameters", "start"}:
            found[values].pop(text.partition("=")[0].strip(), None)
    return found


def _refuse_instants(case: "Case", context: typer.Context) -> None:
    """Refuse listed instants where a sweep would take others in their place."""
    if context.info_name == "sweep":
        raise InputError(
            f"{case.path}: run.t_eval lists output instants, and a sweep takes so many at equal "
            "distances; give their number, in the case or by --points."
        )
