"""The published schemas are those of the code, and the examples of the documentation fit them."""

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from codegen.errors import InputError
from docs.make_schemas import FOLDER, SCHEMAS, text_of
from runtime import load_case
from runtime.cases.fields import RUN, schema
from runtime.core.kinds import ANALYSES
from runtime.machine_facade import Machine


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_fresh_and_valid(name: str) -> None:
    assert (FOLDER / name).read_text(encoding="utf-8") == text_of(name)
    jsonschema.Draft202012Validator.check_schema(json.loads(text_of(name)))


def test_words_of_a_case_are_those_of_the_machine() -> None:
    import inspect

    others = {"self", "parameters", "start", "guess", "progress", "controllers", "out"}
    for analysis in ANALYSES:
        words = {*inspect.signature(getattr(Machine, analysis)).parameters} - others
        assert {*RUN[analysis].model_fields} == words


CASES: list[dict[str, Any]] = [
    {"model": "x"},
    {"model": "x", "run": {"t_end": 1, "t_eval": "steps", "until": {"a": "b.x < 1 mm"}}},
    {"model": "x", "run": {"t_eval": [0, "20 ms"], "rtol": 1e-8, "max_steps": 5}},
    {"model": "x", "analysis": "equilibrium", "run": {"t": "1 s", "method": "settling"}},
    {"model": "x", "scene": {"name": "a", "outputs": ["energy"], "until": {"b": "c.x > 1"}}},
    {"model": 3},
    {"model": ""},
    {"mode": "x"},
    {"model": "x", "run": {"rtol": "1e-8"}},
    {"model": "x", "run": {"t_eval": 1}},
    {"model": "x", "run": {"t_eval": []}},
    {"model": "x", "run": {"until": {"a": "b.x"}}},
    {"model": "x", "run": {"max_steps": 0}},
    {"model": "x", "analysis": "equilibrium", "run": {"rtol": 1e-8}},
    {"model": "x", "analysis": "walk"},
    {"model": "x", "scene": {"effects": ["a"]}},
    {"model": "x", "scene": {"name": "a", "frozen": 1}},
    {"model": "x", "parameters": {"a": "twelve"}},
    {"model": "x", "parameters": {"a": True}},
    {"model": "x", "parameters": {"a": None}},
    {"model": "x", "format": "linkwright case 1"},
    {"model": "x", "format": "1"},
]


@pytest.mark.parametrize("data", CASES, ids=json.dumps)
def test_the_schema_accepts_what_the_reader_accepts(data: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "case.json").write_text(json.dumps(data))
    try:
        load_case(tmp_path / "case.json")
        read = True
    except InputError:
        read = False
    assert jsonschema.Draft202012Validator(schema()).is_valid(data) == read


def test_cases_of_the_documentation_are_cases(root: Path, tmp_path: Path) -> None:
    page = (root / "docs" / "how-to" / "cases.md").read_text(encoding="utf-8")
    found = re.findall(r"```(yaml|json)\n(.*?)```", page, re.DOTALL)
    whole = [
        (ending, text) for ending, text in found if re.search(r'^\{?\s*"?model"?:', text, re.M)
    ]
    assert len(whole) >= 3
    for ending, text in whole:
        (tmp_path / f"case.{ending}").write_text(text, encoding="utf-8")
        load_case(tmp_path / f"case.{ending}")
        data = load_case(tmp_path / f"case.{ending}").data
        jsonschema.validate(data, schema())
        assert ending == "json" or yaml.safe_load(text)["model"] == data["model"]
