"""The options of a simulation, which every command that simulates takes."""

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from operator import attrgetter
from typing import Annotated, Any

from codegen.condition_texts import read_condition
from codegen.errors import InputError
from codegen.quantities import QuantityError
from runtime.cli.common import option
from runtime.integrate.simulation_options import OPTIONS, SimulationOption

_TYPES: dict[str, Any] = {
    "number": float | None, "seconds": float | None, "count": int | None, "text": str | None,
    "names": list[str] | None, "conditions": list[str] | None,
}  # fmt: skip
_OF_SEVERAL = (
    "With --accuracy: a series whose error counts; all coordinates and velocities unless given."
)
_CONDITION = (
    '"NAME: SERIES > VALUE", or with <: the run ends where this begins to hold; again for more.'
)
_SINGULAR = {"quantities": ("quantity", _OF_SEVERAL), "until": ("until", _CONDITION)}
"""Options that are given once a value, with another name or text."""


def _parameter(of: SimulationOption) -> Parameter:
    """An option as typer takes it."""
    name, about = _SINGULAR.get(of.name, (of.name, of.about))
    kind = str if of.default is not None else _TYPES[of.kind]
    least = {"min": 1} if of.kind == "count" else {}
    annotated: Any = Annotated
    return Parameter(
        name, Parameter.KEYWORD_ONLY, default=of.default,
        annotation=annotated[kind, option(about, **least)],
    )  # fmt: skip


_PARAMETERS = {one.name: one for one in map(_parameter, filter(attrgetter("of_commands"), OPTIONS))}


def with_run_options(
    command: Callable[..., None], *, without: tuple[str, ...] = ()
) -> Callable[..., None]:
    """The command with these options in place of its `**run`, of which they are the words.

    Those that the command has itself, and those `without`, are left out.
    """

    @wraps(command)
    def taking(*arguments: Any, **options: Any) -> None:
        command(*arguments, **options)

    about = signature(command)
    own = [p for p in about.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
    left_out = {*about.parameters, *without}
    more = [p for p in _PARAMETERS.values() if p.name not in left_out]
    own = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in own]
    taking.__signature__ = about.replace(parameters=[*own, *more])  # type: ignore[attr-defined]
    kinds = {p.name: p.annotation for p in (*own, *more)}
    taking.__annotations__ = {**kinds, "return": None}
    return taking


def words(run: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """The words of `Machine.simulate` for options, with values; conditions of both hold."""
    given = {"quantities" if name == "quantity" else name: value for name, value in run.items()}
    until = _conditions(given["until"]) if given.get("until") else {}
    return {**given, **values, "until": {**values.get("until", {}), **until} or None}


def _conditions(texts: list[str]) -> dict[str, tuple[str, str, float]]:
    """Conditions that end a run, of the form ``home: body.x > 3``; InputError with all others."""
    found, problems = dict[str, tuple[str, str, float]](), []
    for text in texts:
        name, _, condition = text.partition(":")
        name = name.strip()
        try:
            series, sign, number = read_condition(condition if name else "")
            value = float(number)
        except (QuantityError, ValueError):
            problems.append(
                f'--until "{text}": write "NAME: SERIES > VALUE", or with <, such as '
                '"home: body.x > 3": a name, a series of the result and a number.'
            )
            continue
        if name in found:
            problems.append(f'--until "{text}": {name!r} names another condition already.')
        found[name] = series, sign, value
    if problems:
        raise InputError(problems)
    return found


def refuse_run_options(run: dict[str, Any], title: str) -> None:
    """Raise InputError where one is given that a prescribed motion would ignore."""
    given = [
        f"--{name.replace('_', '-')}"
        for name, value in run.items()
        if value not in (None, [])
        and (name not in _PARAMETERS or value != _PARAMETERS[name].default)
    ]
    if given:
        raise InputError(
            f"{title}: drivers prescribe the motion, and nothing is integrated, so "
            f"{', '.join(given)} would be ignored. Leave out what a simulation takes."
        )
