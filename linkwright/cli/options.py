"""Options that several commands share: the machine, its values, and a simulation's own.

A case file may stand in place of MODEL: its values hold where no option gives another one.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial, wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from codegen.errors import InputError
from codegen.files.library_folders import model_names
from codegen.readers.quantities import QUANTITY, read_condition
from linkwright.cli import completion
from runtime.integrate.simulation_options import OPTIONS, SimulationOption

if TYPE_CHECKING:
    import codegen
    from runtime.cases.case import Case
    from runtime.machine_facade import Machine

Command = TypeVar("Command", bound=Callable[..., None])
_CASES = (".yaml", ".yml", ".json")
_OTHER_MEANING = {
    "accuracy": {"points", "quantities"}, "matters": {"points"}, "sweep": {"quantities"}
}  # fmt: skip
"""Options of a study that are no word of a run, though they have its name."""


def examples(*lines: str) -> str:
    """Command lines that stand below the help of a command, and run as they stand.

    They do so in a folder with `four_bar.py`, which `linkwright new four_bar` writes, unless they
    name a model of the library.
    """
    return "\n\n".join(("Examples:", *lines))


def commands(app: typer.Typer, panel: str) -> Callable[..., Callable[[Command], Command]]:
    """A decorator of commands in a panel of the help, by the examples that stand below theirs."""
    return lambda *lines, name=None: app.command(
        name, epilog=examples(*lines), rich_help_panel=panel
    )


def option(default: Any, text: str, *names: str, panel: str | None = None, **more: Any) -> Any:
    """An option of a command, with its help and the panel of the help where it stands."""
    return typer.Option(default, *names, help=text, rich_help_panel=panel, **more)


machine, time, study, integration, picture, output = (
    partial(option, panel=panel)
    for panel in ("Machine", "Time", "Study", "Integration", "Picture", "Output")
)
scene = partial(machine, metavar="SCENE", autocompletion=completion.scenes)
pair = partial(machine, metavar="NAME=VALUE", autocompletion=completion.coordinates)
series = partial(option, metavar="SERIES", autocompletion=completion.quantities)
method = partial(integration, metavar="METHOD", autocompletion=completion.methods)
formulation = partial(integration, metavar="FORM", autocompletion=completion.formulations)


def given_or_only(context: typer.Context, model: Any) -> Any:
    """The models that are given, or the only one of the working folder; InputError without one."""
    if model or context.resilient_parsing:
        return model
    here = Path.cwd()
    local = model_names(here)
    if len(local) == 1 and here.name != "models":
        only = f"{local[0]}.py"
        return [only] if isinstance(model, list) else only
    if not local:
        raise InputError(
            "no model is given, and this folder has none. Give the path of a model file or the "
            "name of a model, or write one to start from: linkwright new NAME."
        )
    some = ", ".join(f"{name}.py" for name in local[:8]) + (", ..." if len(local) > 8 else "")
    raise InputError(f"no model is given, and this folder has several: {some}. Give one of them.")


def _model_or_case(context: typer.Context, given: str) -> Any:
    """The model, or the case of that name, whose words become defaults of the options."""
    if context.resilient_parsing or not given.lower().endswith(_CASES):
        return str(given_or_only(context, given))
    from runtime.cases.case import load_case

    case = load_case(given)
    context.default_map = {**(context.default_map or {}), **_options_of(case, context)}
    return case


def _options_of(case: "Case", context: typer.Context) -> dict[str, Any]:
    """The words of a case by the names of the options that they stand for."""
    from runtime.cases.fields import read_run
    from runtime.core.kinds import ANALYSES, analysis_name

    command = context.info_name or ""
    analysis, asked = analysis_name(command), case.analysis.replace("_", "-")
    if analysis in ANALYSES and analysis != case.analysis:
        raise InputError(
            f"{case.path}: the case asks for {asked}, and the command is {command}. Run: "
            f"linkwright {asked} {case.path}"
        )
    words = read_run(case.analysis, case.run)
    words.pop("until", None)  # which joins those of the option
    if "unknown" in words and analysis not in (*ANALYSES, "report"):
        raise InputError(f"{case.path}: {command} seeks no values; leave run.unknown out.")
    if type(instants := words.pop("t_eval", None)) is int:
        words["points"] = instants
    if isinstance(case.scene, str):
        words["scene"] = case.scene
    if case.analysis != ANALYSES[0]:
        words["analysis"] = asked  # of studies
    if command == "sweep" and case.analysis == "equilibrium":
        if "t" in words:
            words["t_start"] = words.pop("t")
        if "method" in words:
            raise InputError(
                f"{case.path}: a sweep finds equilibria by the usual method; leave run.method out."
            )
    left_out = _OTHER_MEANING.get(command, set())
    return {name: value for name, value in words.items() if name not in left_out}


_FILE = "Path of a model file, or a name: models/NAME.py."
_model = partial(
    typer.Argument,
    metavar="MODEL",
    show_default="the only one of the folder",
    callback=given_or_only,
    autocompletion=completion.models,
)
ModelFile = Annotated[str, _model(help=_FILE, default_factory=str)]
ModelFiles = Annotated[list[str], _model(help=f"{_FILE} One or several.", default_factory=list)]
Scene = Annotated[str | None, scene(..., "Scene of the model; the first unless given.")]
AnyScene = Annotated[str | None, scene(..., "One scene; all unless given.")]
Values = Annotated[
    list[str] | None,
    pair(..., 'A parameter, in SI units or with a unit, "length=45 mm"; repeat for more.', "--set",
         autocompletion=completion.settings),
]  # fmt: skip
Generated = Annotated[
    Path | None, machine(..., "Folder of the generated modules, the --out of build.")
]
MotionStart = Annotated[float, time(..., "First instant in s; the start values belong to it.")]
TEnd = Annotated[float, time(..., "Last instant in s.")]
OptionalTEnd = Annotated[float | None, time(..., "Last instant in s.")]
Points = Annotated[
    int | None, time(..., "Number of output instants, ends included; 501 unless given.", min=2)
]
Analysis = Annotated[
    str | None,
    study(..., "simulate, kinematics, inverse-dynamics or equilibrium (which needs no --t-end); "
          "follows from the scene unless given.", autocompletion=completion.analyses),
]  # fmt: skip
Check = Annotated[bool, output(..., "Write nothing; fail if a file is out of date.", "--check")]
Json = Annotated[bool, output(..., "Print one JSON object on stdout.", "--json")]


@dataclass(frozen=True)
class Request:
    """The machine and the values that a command is about, as its options give them."""

    model: Annotated[
        str,
        _model(
            help=f"{_FILE} Or a case, .yaml or .json; options override its values.",
            default_factory=str,
            callback=_model_or_case,  # which may put a case in its place
            is_eager=True,
        ),
    ]
    scene: Scene = None
    settings: Values = None
    start: Annotated[list[str] | None, pair(
        ..., 'A start value that is kept, in SI units or with a unit, "crank.omega=60 rpm".'
    )] = None  # fmt: skip
    guess: Annotated[
        list[str] | None,
        pair(..., "A value, as for --start, at which the search for the start begins."),
    ] = None
    generated: Generated = None
    as_json: Json = False
    run: dict[str, Any] = field(default_factory=dict)  # the options of a simulation
    own: dict[str, Any] = field(default_factory=dict)  # those of the command itself that are given

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

    def words(self, machine: "Machine | None" = None, varied: Iterable[str] = ()) -> dict[str, Any]:
        """The words of an analysis: `parameters`, `guess`, `start` where given, and of its run.

        The options stand over the values of a case, which may bring instants besides where the
        machine is known; without it, that of the case is loaded for its units. Conditions of both
        hold. Names that a sweep has `varied` are left out of the case.
        """
        problems, of_case = list[str](), dict[str, Any]()
        given: dict[str, dict[str, Any]] = {
            "parameters": named_values("--set", self.settings, problems, _assignment),
            "guess": named_values("--guess", self.guess, problems, _assignment),
            "start": named_values("--start", self.start, problems, _assignment),
            "until": named_values("--until", self.run.get("until"), problems, _condition),
        }
        if problems:
            raise InputError(problems)
        if not self.run:  # of what integrates nothing
            del given["until"]
        if self.case is not None:
            of_case = self.case.words(machine or self.case.machine())
            for word, values in given.items():
                stated = of_case.pop(word, {}).items()
                given[word] = {k: x for k, x in stated if k not in varied} | values
            own = ("t_eval", "unknown", "weights") if machine else ()
            of_case = {k: x for k, x in of_case.items() if k in own}
        run = {name: value for name, value in self.run.items() if name != "until"}
        return run | of_case | {word: values for word, values in given.items() if values}

    def refuse_run_options(self, title: str) -> None:
        """Raise InputError where one is given that a prescribed motion would ignore."""
        given = [
            "--quantity" if name == "quantities" else f"--{name.replace('_', '-')}"
            for name, value in self.run.items()
            if value not in (None, [], _OF_RUNS[name].default)
        ]
        if given:
            raise InputError(
                f"{title}: drivers prescribe the motion, and nothing is integrated, so "
                f"{', '.join(given)} would be ignored. Leave out what a simulation takes."
            )


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
        "text": '"NAME: SERIES > VALUE", or with <: the run ends where it begins to hold; '
        "repeat for more.",
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
        annotation=annotated[kind, integration(..., look.pop("text"), *look.pop("names"), **look)],
    )  # fmt: skip


_OF_RUNS = {one.name: one for one in map(_parameter, (o for o in OPTIONS if o.of_commands))}


def with_request(
    *, simulates: bool = False, without: tuple[str, ...] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """A decorator: the command with the options of its `Request`, and of a simulation.

    Those that the command has itself, and those `without`, are left out.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        _, *own = signature(command).parameters.values()
        left_out = {*without, "run", "own", *(parameter.name for parameter in own)}
        of_runs = [p for p in _OF_RUNS.values() if simulates and p.name not in left_out]
        first, *rest = (p for p in signature(Request).parameters.values() if p.name not in left_out)

        @wraps(command)
        def taking(**options: Any) -> None:
            run = {p.name: options.pop(p.name) for p in of_runs}
            words = {p.name: options.pop(p.name) for p in (first, *rest)}
            given = {name: value for name, value in options.items() if value not in (None, [])}
            command(Request(**words, run=run, own=given), **options)

        taken = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in (first, *own, *rest, *of_runs)]
        about: Any = taking
        about.__signature__ = signature(command).replace(parameters=taken)
        about.__annotations__ = {p.name: p.annotation for p in taken}
        return taking

    return decorate


def named_values(
    option: str, texts: Iterable[str] | None, problems: list[str],
    read: Callable[[str], tuple[str, Any]],
) -> dict[str, Any]:  # fmt: skip
    """The values of an option that takes several with a name; what is wrong joins the problems."""
    values = dict[str, Any]()
    for text in texts or ():
        try:
            name, value = read(text)
        except ValueError as error:
            problems.append(f"{option} {error}")
            continue
        if name in values:
            problems.append(f"{option} {name} is given twice; give one value.")
        values[name] = value
    return values


def _number(text: str) -> float | str:
    """A number, or the text of one with its unit; ValueError for all else."""
    try:
        return float(text)
    except ValueError:
        if QUANTITY.fullmatch(text):
            return text.strip()
        raise


def _assignment(text: str) -> tuple[str, float | str]:
    name, _, value = text.partition("=")
    try:
        return name.strip(), _number(value)  # "" where there is no =
    except ValueError:
        raise ValueError(
            f'{text}: write NAME=VALUE with a number, or with one and its unit, "NAME=45 mm".'
        ) from None


def _condition(text: str) -> tuple[str, tuple[str, str, float | str]]:
    """A condition that ends a run, of the form ``home: body.x > 3``."""
    name, _, condition = text.partition(":")
    try:
        series, sign, number = read_condition(condition if name.strip() else "")
        return name.strip(), (series, sign, _number(number))
    except ValueError:
        raise ValueError(
            f'"{text}": write "NAME: SERIES > VALUE", or with <, such as "home: body.x > 3": a '
            "name, a series of the result and a number, perhaps with its unit."
        ) from None


def parameters(settings: list[str] | None) -> dict[str, float | str]:
    """The values of --set; InputError with all that is wrong."""
    return dict(Request("", settings=settings).words().get("parameters", {}))
