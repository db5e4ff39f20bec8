"""Arguments of `Machine.simulate` that a study hands to each of its runs: all that it does not set.

They have the annotations and defaults of `Machine.simulate`, where they are explained.
"""

from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Parameter, signature
from typing import Any, ParamSpec, TypeVar

from codegen.errors import InputError
from runtime.dynamics.output_conditions import read_conditions
from runtime.integrate.simulation_options import OPTIONS
from runtime.machine_facade import Machine
from runtime.validation.arguments import check

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")
_OF_THE_STUDY = {
    *("self", "parameters", "guess", "start", "progress", "out"),
    *(option.name for option in OPTIONS if not option.of_studies),
}


def takes_simulation_arguments(
    *without: str,
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """A study with these words in place of its `**run`, which receives those that are given.

    `without` are words that the study sets besides.
    """

    def decorate(study: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        @wraps(study)
        def taking(*positional: Arguments.args, **named: Arguments.kwargs) -> Answer:
            return study(*positional, **named)

        about, words = signature(study), signature(Machine.simulate).parameters.values()
        own = [p for p in about.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        more = [p for p in words if p.name not in {*_OF_THE_STUDY, *without}]
        more = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in more]
        taking.__signature__ = about.replace(parameters=[*own, *more])  # type: ignore[attr-defined]
        return taking

    return decorate


def read_simulation_arguments(machine: Machine, run: Mapping[str, Any]) -> dict[str, Any]:
    """Those with another value than that of `Machine.simulate`; InputError where some misfit."""
    usual = {name: word.default for name, word in signature(Machine.simulate).parameters.items()}
    given = {name: value for name, value in run.items() if value is not usual[name]}
    until = given.pop("until", None)
    words = check(machine.mechanism, **given)
    if until is not None:
        read_conditions(machine.description, until)
        words["until"] = until
    return words


def refuse_simulation_arguments(run: Mapping[str, Any], title: str, analysis: str) -> None:
    """Raise InputError where words are given to a study of an analysis that integrates nothing."""
    if run:
        raise InputError(
            f"{title}: {analysis} integrates nothing, so {', '.join(run)} would be ignored. Leave "
            "out what a simulation takes."
        )


def arguments_of_variant(machine: Machine, run: Mapping[str, Any]) -> dict[str, Any]:
    """The words for a variant of a scene: it has the controllers of its own sampled values."""
    words = dict(run)
    if words.get("controllers"):
        own = machine.description.controllers
        words["controllers"] = {k: one for k, one in words["controllers"].items() if k in own}
    return words
