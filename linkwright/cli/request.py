"""The machine and the values that a command is about, and the options of its run.

A case file may stand in place of MODEL: its values hold where no option gives another one.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Annotated, Any

import typer

from codegen.errors import InputError
from codegen.readers.quantities import read_condition
from linkwright.cli import completion
from linkwright.cli.options import (
    FILE,
    Generated,
    Json,
    Scene,
    Values,
    assigned,
    given_or_only,
    integration,
    model,
    pair,
)
from runtime.integrate.problem import OPTIONS, SimulationOption

if TYPE_CHECKING:
    import codegen
    from runtime.cases.case import Case
    from runtime.machine_facade import Machine

_ENDINGS = (".yaml", ".yml", ".json")
_OTHER_MEANING = {"accuracy": {"method", "formulation", "points"}, "matters": {"points"}}
"""Options of a study that are no word of a run, though they have its name."""


def model_or_case(context: typer.Context, given: str) -> Any:
    """The model, or the case of that name, whose words become defaults of the options."""
    if context.resilient_parsing or not given.lower().endswith(_ENDINGS):
        return str(given_or_only(context, given))
    from runtime.cases.case import load_case

    case = load_case(given)
    context.default_map = {**(context.default_map or {}), **_options(case, context)}
    return case


def _options(case: "Case", context: typer.Context) -> dict[str, Any]:
    """The words of a case by the names of the options that they stand for."""
    from runtime.cases.fields import read_run
    from runtime.core.kinds import ANALYSES, analysis_name

    command = context.info_name or ""
    analysis = analysis_name(command)
    if analysis in ANALYSES and analysis != case.analysis:
        asked = case.analysis.replace("_", "-")
        raise InputError(
            f"{case.path}: the case asks for {asked}, and the command is {command}. Run: "
            f"linkwright {asked} {case.path}"
        )
    words = read_run(case.analysis, case.run)
    words.pop("until", None)  # which joins those of the option
    if type(instants := words.pop("t_eval", None)) is int:
        words["points"] = instants
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


@dataclass(frozen=True)
class Request:
    """The machine and the values that a command is about, as its options give them."""

    model: Annotated[
        str,
        model(
            help=f"{FILE} Or a case, .yaml or .json, whose values hold where no option gives "
            "another one.",
            default_factory=str,
            callback=model_or_case,  # which may put a case in its place
            is_eager=True,
        ),
    ]
    scene: Scene = None
    settings: Values = None
    start: Annotated[list[str] | None, pair("A start value that is kept, in SI units.")] = None
    guess: Annotated[
        list[str] | None,
        pair("Where the search for a start begins, in SI units; no name that is fixed."),
    ] = None
    generated: Generated = None
    as_json: Json = False

    @property
    def case(self) -> "Case | None":
        """The case that stands in place of the model."""
        given: Any = self.model
        return None if isinstance(given, str) else given

    def source(self) -> "tuple[str | codegen.Model, str | codegen.Scene | None]":
        """The model and the scene, as `load` and the studies take them."""
        if self.case is None:
            return self.model, self.scene
        return (self.case.model_path, self.scene) if self.scene else self.case.source()

    def machine(self) -> "Machine":
        """The machine."""
        from runtime.machine_loading import load

        if self.case is not None and self.scene is None:
            return self.case.machine(generated=self.generated)
        return load(*self.source(), generated=self.generated)

    def values(
        self, machine: "Machine | None" = None, varied: Iterable[str] = ()
    ) -> dict[str, Any]:
        """The arguments `parameters`, `guess` and `start` of an analysis, the last where given.

        The options stand over the values of a case, which may bring conditions and, where the
        machine is known, instants besides; without it, that of the case is loaded for its units.
        Names that a sweep has `varied` are left out of the case.
        """
        problems = list[str]()
        values = {
            "parameters": assigned("--set", self.settings, problems),
            "guess": assigned("--guess", self.guess, problems),
        }
        if self.start:
            values["start"] = assigned("--start", self.start, problems)
        if problems:
            raise InputError(problems)
        if self.case is None:
            return dict(values)
        of_case = self.case.words(machine or self.case.machine())
        kept = ("parameters", "start", "guess", "until", *(("t_eval",) if machine else ()))
        found = {name: of_case[name] for name in kept if name in of_case}
        for word in found.keys() & {"parameters", "start"}:
            found[word] = {k: v for k, v in found[word].items() if k not in varied}
        return found | {word: found.get(word, {}) | given for word, given in values.items()}


_KINDS: dict[str, Any] = {
    "number": float | None, "seconds": float | None, "count": int | None, "text": str | None,
    "names": list[str] | None, "conditions": list[str] | None,
}  # fmt: skip
_LOOKS: dict[str, dict[str, Any]] = {
    "quantities": {
        "names": ("--quantity",), "metavar": "SERIES", "autocompletion": completion.quantities,
        "text": "With --accuracy: a series whose error counts; all coordinates and velocities "
        "unless given.",
    },
    "until": {
        "metavar": "CONDITION",
        "text": '"NAME: SERIES > VALUE", or with <: the run ends where this begins to hold; again '
        "for more.",
    },
    "method": {"metavar": "METHOD", "autocompletion": completion.methods},
    "formulation": {"metavar": "FORM", "autocompletion": completion.formulations},
    "correction": {"metavar": "WAY", "autocompletion": completion.corrections},
    "max_steps": {"min": 1},
}  # fmt: skip


def _parameter(of: SimulationOption) -> Parameter:
    """An option of a simulation as Typer takes it."""
    look = {"text": of.about, "names": (), **_LOOKS.get(of.name, {})}
    kind = str if of.default is not None else _KINDS[of.kind]
    annotated: Any = Annotated
    return Parameter(
        of.name, Parameter.KEYWORD_ONLY, default=of.default,
        annotation=annotated[kind, integration(look.pop("text"), *look.pop("names"), **look)],
    )  # fmt: skip


_OF_RUNS = {one.name: one for one in map(_parameter, (o for o in OPTIONS if o.of_commands))}


def with_request(
    command: Callable[..., None], *, without: tuple[str, ...] = ()
) -> Callable[..., None]:
    """The command with the options of its `Request`, and of a simulation where it has a `**run`.

    Those that the command has itself, and those `without`, are left out.
    """

    @wraps(command)
    def taking(**options: Any) -> None:
        words = {f.name: options.pop(f.name) for f in fields(Request) if f.name in options}
        command(Request(**words), **options)

    _, *own = signature(command).parameters.values()
    more = list(signature(Request).parameters.values())
    if own[-1].kind is Parameter.VAR_KEYWORD:
        own.pop()
        more += _OF_RUNS.values()
    left_out = {*without, *(p.name for p in own)}
    first, *rest = (p for p in more if p.name not in left_out)
    taken = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in (first, *own, *rest)]
    taking.__signature__ = signature(command).replace(parameters=taken)  # type: ignore[attr-defined]
    taking.__annotations__ = {p.name: p.annotation for p in taken}
    return taking


def words(run: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """The words of `Machine.simulate` for options, with values; conditions of both hold."""
    until = values.get("until", {}) | _conditions(run.get("until") or ())
    return {**run, **values, "until": until or None}


def _conditions(texts: Iterable[str]) -> dict[str, tuple[str, str, float]]:
    """Conditions that end a run, of the form ``home: body.x > 3``; InputError with all others."""
    found, problems = dict[str, tuple[str, str, float]](), []
    for text in texts:
        name, _, condition = text.partition(":")
        name = name.strip()
        try:
            series, sign, number = read_condition(condition if name else "")
            value = float(number)
        except ValueError:
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
        "--quantity" if name == "quantities" else f"--{name.replace('_', '-')}"
        for name, value in run.items()
        if value not in (None, []) and (name not in _OF_RUNS or value != _OF_RUNS[name].default)
    ]
    if given:
        raise InputError(
            f"{title}: drivers prescribe the motion, and nothing is integrated, so "
            f"{', '.join(given)} would be ignored. Leave out what a simulation takes."
        )
