"""Fields of a case: model, scene, values and the words of an analysis."""

from typing import Any

from runtime.cases.document import Entry
from runtime.cases.schema_types import (
    CONDITION,
    FLAG,
    NUMBER,
    QUANTITY_KIND,
    SECONDS,
    TEXT,
    Either,
    Field,
    Kind,
    ListOf,
    MapOf,
    Note,
    Record,
    choice,
    count,
)
from runtime.core.analysis_names import ANALYSES
from runtime.integrate.simulation_options import OPTIONS

FORMAT = "linkwright case 1"
"""The format and its version."""

_VALUES = MapOf(QUANTITY_KIND)
_NAMES = ListOf(TEXT)
_WORDS = MapOf(TEXT)

SCENE = Record(
    {
        "name": Field(
            TEXT,
            "Name of the scene, which stands in place of the model's own of that name.",
            required=True,
        ),
        "extends": Field(TEXT, "A scene of the model, whose elements and values this one has too."),
        "effects": Field(_NAMES, "Effects that act."),
        "drivers": Field(_NAMES, "Drivers that act."),
        "without": Field(_NAMES, "Bodies, joints, effects and drivers that do not take part."),
        "couplers": Field(_WORDS, "Coupler: body, link or lumped."),
        "fidelity": Field(_WORDS, "Effect, coupler or group: how it is taken."),
        "start": Field(_VALUES, "Coordinate or velocity: value that must hold at the beginning."),
        "guess": Field(_VALUES, "Coordinate or velocity: value from which assembly starts."),
        "parameters": Field(_VALUES, "Parameter: value in place of the declared one."),
        "frozen": Field(FLAG, "Whether the parameters are folded into the code."),
        "analysis": Field(
            choice(("dynamics", "kinematics", "equilibrium")), "What is compiled; dynamics."
        ),
        "outputs": Field(_NAMES, 'Outputs in addition to the motion, such as "force(strut)".'),
        "until": Field(MapOf(CONDITION), "Name: condition on a position or velocity; ends runs."),
    },
    title="scene",
    about="A scene that the model does not declare, in the words of Model.scene.",
)

_INSTANTS = Either(choice(("steps",)), ListOf(SECONDS, least=1))


class _Instants:
    """How many output instants, which ones, or the word `steps`."""

    number = count(2)

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        kind: Kind = self.number if type(entry.value) in (int, float, bool) else _INSTANTS
        kind.check(entry, where, note)

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        return {"anyOf": [self.number.schema(), *_INSTANTS.schema()["anyOf"]]}


_KINDS: dict[str, Kind] = {
    "number": NUMBER, "seconds": SECONDS, "count": count(1), "text": TEXT, "names": _NAMES,
    "conditions": MapOf(CONDITION), "instants": _Instants(),
}  # fmt: skip
_SIMULATION = {option.name: Field(_KINDS[option.kind], option.about) for option in OPTIONS}

RUN = {
    "simulate": Record(_SIMULATION),
    "kinematics": Record({name: _SIMULATION[name] for name in ("t_end", "t_eval", "t_start")}),
    "equilibrium": Record(
        {
            "method": Field(choice(("energy", "settling")), "How the position is searched for."),
            "t": Field(SECONDS, "Instant at which drivers and forces are frozen, s."),
        }
    ),
}
RUN["inverse_dynamics"] = RUN["kinematics"]
"""Analysis → its words, those of the method of `Machine`."""

CASE = {
    "format": Field(choice((FORMAT,)), "The format of the file, and its version."),
    "model": Field(
        TEXT,
        "Name of a model, models/NAME.py, or path of its file ending in .py, as seen from the "
        "folder of the case.",
        required=True,
    ),
    "scene": Field(Either(TEXT, SCENE), "Name of a scene, or a scene; the first unless given."),
    "analysis": Field(choice(ANALYSES), "The analysis; simulate unless given."),
    "parameters": Field(_VALUES, "Parameter: value, in its declared unit unless it has one."),
    "start": Field(_VALUES, "Coordinate, velocity or state: start value that is kept, SI units."),
    "guess": Field(_VALUES, "The same: where the search for a start begins."),
    "run": Field(RUN["simulate"], "The words of the analysis, as those of Machine.simulate."),
}
"""Fields of a case; those of `run` are of the analysis."""


def case_record(analysis: str) -> Record:
    """The record of a case with this analysis."""
    return Record({**CASE, "run": Field(RUN[analysis], CASE["run"].about)})


def schema() -> dict[str, Any]:
    """The JSON schema of a case, draft 2020-12; the words of `run` follow from the analysis."""
    whole = case_record(ANALYSES[0]).schema()
    whole["properties"]["run"] = {"type": "object", "description": CASE["run"].about}
    branches = list[dict[str, Any]]()
    for analysis in ANALYSES:
        chosen: dict[str, Any] = {"properties": {"analysis": {"const": analysis}}}
        if analysis != ANALYSES[0]:  # which a case without the key means
            chosen["required"] = ["analysis"]
        branches.append({"if": chosen, "then": {"properties": {"run": RUN[analysis].schema()}}})
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:linkwright:case:1",
        **whole,
        "title": "Case of Linkwright",
        "description": "Model, scene, values and settings of a run: data, and no code.",
        "allOf": branches,
    }
