"""Fields of a case: model, scene, values and the words of an analysis; their check and schema."""

import math
import re
from collections.abc import Callable, Container, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Union

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    create_model,
)
from pydantic.json_schema import GenerateJsonSchema

from codegen.readers.quantities import (
    FORM,
    QUANTITY,
    ConditionText,
    number_in,
    pint_form,
    read_condition,
)
from codegen.readers.values import shown
from runtime.cases.document import Document, Place
from runtime.core.kinds import ANALYSES
from runtime.integrate.simulation_options import OPTIONS
from runtime.mechanism.table_rows import unknown

FORMAT = "linkwright case 1"
"""The format and its version."""

_LONGEST = 4096  # safety: characters of a text
_MOST = 2**62  # safety: of a count
_QUANTITY = 'a finite number, or a text of a number and its unit, such as "1.2 m"'
_SECONDS = 'a finite number of seconds, or a text such as "20 ms"'
_CONDITION = 'a condition "SERIES > VALUE", or with <, such as "body.x > 3"'


def _wrong(value: object, demand: str) -> ValueError:
    return ValueError(f"{shown(value)}: it must be {demand}.")


def _text(value: object, demand: str = "a text") -> str:
    if not isinstance(value, str):
        raise _wrong(value, demand)
    if not value or len(value) > _LONGEST or not value.isprintable():
        raise _wrong(value, f"a text of 1 to {_LONGEST} characters that print")
    return value


def _number(value: Any, demand: str = "a finite number") -> Any:
    try:
        if type(value) in (int, float) and math.isfinite(float(value)):
            return value
    except OverflowError:
        raise ValueError("it is beyond all floats.") from None
    raise _wrong(value, demand)


def _quantity(value: object, demand: str = _QUANTITY) -> Any:
    """Whether its unit fits is looked at where the one that is needed is known."""
    if not isinstance(value, str):
        return _number(value, demand)
    parts = QUANTITY.fullmatch(_text(value))  # YAML would write another text of what does not print
    if parts is None or not math.isfinite(float(parts[1])):
        raise _wrong(value, demand)
    try:
        pint_form(parts[2] or "1")
    except ValueError:
        raise ValueError(
            f"{shown(parts[2])} is no unit; write products of powers, such as kg m^2 or N m/rad."
        ) from None
    return value


def _seconds(value: object) -> Any:
    return number_in(_text(value), "s") if isinstance(value, str) else _number(value, _SECONDS)


def _condition(value: object) -> ConditionText:
    condition = read_condition(_text(value, _CONDITION))
    _quantity(condition.value, _CONDITION)
    return condition


def _kind(reader: Callable[[Any], object], form: dict[str, Any]) -> Any:
    """A kind of values: its reader, which raises ValueError, and its JSON schema."""
    kind: Any = Annotated
    return kind[Any, PlainValidator(reader), WithJsonSchema(form)]


_WITH_UNIT = QUANTITY.pattern.replace(r"(\S.*)?", r"(\S(.|\n)*)?")
_WITH_UNIT_FORM = {"anyOf": [{"type": "number"}, {"type": "string", "pattern": f"^{_WITH_UNIT}$"}]}
Text: Any = _kind(_text, {"type": "string", "minLength": 1})
Condition: Any = _kind(_condition, {"type": "string", "pattern": FORM})
Seconds: Any = _kind(_seconds, _WITH_UNIT_FORM)
Names: Any = list[Text]
Words: Any = dict[Text, Text]
Quantity: Any = _kind(_quantity, _WITH_UNIT_FORM)
Values: Any = dict[Text, Quantity]
Conditions: Any = dict[Text, Condition]

_TAG = "\0"  # begins what stands for an alternative in the places of errors; no text has it


def _one_of(choice: Callable[[Any], str], **kinds: Any) -> Any:
    """A value of one of several kinds, by a function that returns the word of its kind."""
    union: Any = Union
    tagged = tuple(Annotated[kind, Tag(_TAG + word)] for word, kind in kinds.items())
    return Annotated[union[tagged], Discriminator(lambda value: _TAG + choice(value))]


class _Keys(BaseModel):
    """A mapping with known keys."""

    model_config = ConfigDict(extra="forbid", strict=True)


def _key(about: str, *, required: bool = False) -> Any:
    """A key and its meaning; a default that a function makes does not appear in the schema."""
    return Field(description=about) if required else Field(description=about, default_factory=dict)


class Scene(_Keys):
    """A scene that the model does not declare, in the words of Model.scene."""

    name: Text = _key(
        "Name of the scene, which stands in place of the model's own of that name.", required=True
    )
    extends: Text = _key("A scene of the model, whose elements and values this one has too.")
    effects: Names = _key("Effects that act, besides those of the scene that it extends.")
    drivers: Names = _key("Drivers that act, besides those of the scene that it extends.")
    without: Names = _key("Bodies, joints, effects and drivers that do not take part.")
    couplers: Words = _key("Coupler: body, link or lumped.")
    fidelity: Words = _key("Effect, coupler or group: how it is taken.")
    start: Values = _key("Coordinate or velocity: value that must hold at the beginning.")
    guess: Values = _key("Coordinate or velocity: value from which assembly starts.")
    parameters: Values = _key("Parameter: value in place of the declared one.")
    frozen: bool = _key("Whether the parameters are folded into the code.")
    analysis: Literal["dynamics", "kinematics", "equilibrium"] = _key("What is compiled; dynamics.")
    outputs: Names = _key('Outputs in addition to the motion, such as "force(strut)".')
    until: Conditions = _key("Name: condition on a position or velocity; ends runs.")


_KINDS = {
    "number": _kind(_number, {"type": "number"}), "seconds": Seconds,
    "count": Annotated[int, Field(ge=1, le=_MOST)],
    "text": Text, "names": Names, "conditions": Conditions,
    "instants": _one_of(
        lambda value: type(value).__name__ if isinstance(value, list | str) else "int",
        int=Annotated[int, Field(ge=2, le=_MOST)], str=Literal["steps"],
        list=Annotated[list[Seconds], Field(min_length=1)],
    ),
}  # fmt: skip


def _words(title: str, names: Container[str]) -> type[BaseModel]:
    """A model of some words of a simulation."""
    words: dict[str, Any] = {
        one.name: (_KINDS[one.kind], _key(one.about)) for one in OPTIONS if one.name in names
    }
    return create_model(title, __base__=_Keys, **words)


class _Rest(_Keys):
    method: Literal["energy", "settling"] = _key("How the position is searched for.")
    t: Seconds = _key("Instant at which drivers and forces are frozen, s.")


_MOTION = _words("Motion", ("t_end", "t_eval", "t_start"))
RUN: dict[str, type[BaseModel]] = {
    "simulate": _words("Simulation", {one.name for one in OPTIONS}),
    "kinematics": _MOTION, "equilibrium": _Rest,
    "inverse_dynamics": create_model(
        "Forces", __base__=_MOTION, unknown=(Names, _key("Effects that do what drivers would.")),
        weights=(Values, _key("Of these, where they are more than drivers: effect: weight.")),
    ),
}  # fmt: skip
"""Analysis → its words, those of the method of `Machine`."""


def read_run(analysis: str, run: Mapping[str, Any]) -> dict[str, Any]:
    """The words of an analysis that are there, times as numbers in s and conditions in parts."""
    read = RUN[analysis].model_validate(run)
    return {name: getattr(read, name) for name in run}


class _Case(_Keys):
    format: Literal["linkwright case 1"] = _key("The format of the file, and its version.")
    model: Text = _key(
        "Name of a model, models/NAME.py, or path of its file ending in .py, as seen from the "
        "folder of the case.",
        required=True,
    )
    scene: _one_of(  # type: ignore[valid-type]
        lambda value: "scene" if isinstance(value, dict | list) else "name", name=Text, scene=Scene
    ) = _key("Name of a scene, or a scene; the first unless given.")
    parameters: Values = _key("Parameter: value, in SI units unless it has one.")
    start: Values = _key("Coordinate, velocity or state: start value that is kept, SI units.")
    guess: Values = _key("The same: where the search for a start begins.")


def _case_of(analysis: str) -> type[BaseModel]:
    literal: Any = Literal
    about = _key("The analysis; simulate unless given.", required=analysis != ANALYSES[0])
    run = _key("The words of the analysis, as those of Machine.simulate.")
    return create_model(
        "Case", __base__=_Case, analysis=(literal[analysis], about), run=(RUN[analysis], run)
    )


_CASES = {analysis: _case_of(analysis) for analysis in ANALYSES}


def analysis_of(data: Any) -> str:
    """The analysis of a case; that of a case without one for what is none."""
    given = data.get("analysis") if isinstance(data, dict) else None
    return given if given in ANALYSES else ANALYSES[0]


@cache
def _adapter() -> TypeAdapter[Any]:
    return TypeAdapter(_one_of(analysis_of, **_CASES))


_DEMANDS = {
    "bool_type": "true or false",
    "int_type": "a whole number",
    "greater_than_equal": "a whole number from {ge} on",
    "less_than_equal": "a whole number up to {le:g}",
    "dict_type": "a mapping, NAME: VALUE",
    "model_type": "a mapping, KEY: VALUE",
    "list_type": "a list",
    "too_short": "a list",
}


def problems_of(document: Document) -> list[str]:
    """Whatever is wrong with a case: a sentence for each problem, with its place."""
    try:
        _adapter().validate_python(document.data)
    except ValidationError as error:
        found = error.errors(include_url=False)
        found.sort(key=lambda one: document.line(_place(one)) or 0)
        return [_sentence(document, one) for one in found]
    return []


def _place(error: Any) -> Place:
    """The place of an error of pydantic's in the document."""
    return tuple(x for x in error["loc"] if x != "[key]" and not str(x).startswith(_TAG))


def _sentence(document: Document, error: Any) -> str:
    at, value, kind, context = _place(error), error["input"], error["type"], error.get("ctx", {})
    if kind in ("extra_forbidden", "missing"):
        analysis = analysis_of(document.data)
        inner: dict[Any, type[BaseModel]] = {"scene": Scene, "run": RUN[analysis]}
        fields = (inner[at[0]] if at[1:] else _CASES[analysis]).model_fields
        *outer, key = at
        why = unknown("key", key, fields)
        if kind == "missing":
            why = f"{key} is missing: {fields[str(key)].description}"
        return document.problem(tuple(outer), why, line_of=at)
    if "error" in context:
        return document.problem(at, str(context["error"]))
    if kind == "literal_error":
        words = re.findall("'([^']*)'", context["expected"])
        why = unknown("word", value, ANALYSES if at == ("analysis",) else words)
        return document.problem(at, why)
    return document.problem(at, f"{shown(value)}: it must be {_DEMANDS[kind].format(**context)}.")


class _WithoutTitles(GenerateJsonSchema):
    """The names of fields say what titles would repeat."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Never."""
        return False


def schema() -> dict[str, Any]:
    """The JSON schema of a case, draft 2020-12; the words of `run` follow from the analysis."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:linkwright:case:1",
        "title": "Case of Linkwright",
        "description": "Model, scene, values and settings of a run: data, and no code.",
        **_adapter().json_schema(schema_generator=_WithoutTitles),
    }
