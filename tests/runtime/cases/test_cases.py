"""Cases: YAML and JSON files of values and settings, read and written with the same bits."""

import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from codegen.errors import InputError
from runtime import Case, load, load_case
from runtime.cases.fields import schema

_MODEL = """
from linkwright import Model
model = Model("cased", gravity=(0, -9.81))
length = model.parameter("length", 1.0, unit="m", sign="positive")
damping = model.parameter("damping", 0.3, unit="N m s")
bob = model.body("bob", mass=2.0, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
model.torque("damper", on=bob, value=-damping * bob.omega)
model.torque("kick", on=bob, value=5.0)
model.scene("swing", ["gravity", "damper"], start={bob.phi: 0.0, bob.omega: 0.0})
"""
_CASE = """
# a long pendulum, started by hand
model: cased.py
scene: swing
parameters: {length: 120 cm, damping: 1e-2}
start:
  bob.phi: 30 deg
  bob.omega: -15 rpm
run: {t_end: 500 ms, t_eval: 11, rtol: 1e-9, method: tsit5}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("cases")
    (place / "cased.py").write_text(_MODEL)
    return place


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder one works in, which is not that of the cases."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(folder: Path, text: str, name: str = "case.yaml") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_a_case_is_the_call_that_it_stands_for(folder: Path) -> None:
    case = load_case(written(folder, _CASE))
    machine = case.machine(generated=folder / "generated")
    assert machine.path.parent == folder / "generated"
    r = case.analyse()
    e = machine.simulate(
        0.5, 11, rtol=1e-9, method="tsit5", parameters={"length": 1.2, "damping": 0.01},
        start={"bob.phi": math.pi / 6, "bob.omega": -math.pi / 2},
    )  # fmt: skip
    np.testing.assert_allclose(r.q("bob.phi"), e.q("bob.phi"), rtol=1e-14)
    assert r.parameters == {"length": 1.2, "damping": 0.01}
    assert len(case.analyse(t_eval=5).t) == 5


def test_files_of_both_formats_and_objects_have_the_same_data(folder: Path) -> None:
    case = load_case(written(folder, _CASE))
    assert case.data["parameters"] == {"length": "120 cm", "damping": 0.01}
    assert case.data["run"]["rtol"] == 1e-9
    jsonschema.validate(case.data, schema())
    for name in ("again.json", "again.yml", "again.yaml"):
        assert load_case(case.save(folder / name)).data == case.data
    made = Case(
        Path("cased.py"), "swing", parameters={"length": "120 cm", "damping": np.float64(0.01)},
        start={"bob.phi": "30 deg", "bob.omega": "-15 rpm"},
        run={"t_end": "500 ms", "t_eval": np.int64(11), "rtol": 1e-9, "method": "tsit5"},
    )  # fmt: skip
    assert made.data == case.data
    assert "length='120 cm'" in repr(made) or "'length': '120 cm'" in repr(made)


def test_the_model_is_found_from_the_folder_of_the_case(folder: Path, tmp_path: Path) -> None:
    case = load_case(written(folder, _CASE))
    (tmp_path / "deep").mkdir()
    moved = load_case(case.save(tmp_path / "deep" / "moved.yaml"))
    assert not Path(moved.model).is_absolute()
    assert moved.source() != case.source()
    assert Path(str(moved.source()[0])).resolve() == folder / "cased.py"
    assert Case("slider_crank").source() == ("slider_crank", None)


_NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**60), 2**60)
_TEXTS = st.text(st.characters(), min_size=1, max_size=12).filter(str.isprintable)


@settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],  # the folder is left as it is
)
@given(values=st.dictionaries(_TEXTS, _NUMBERS, max_size=5), names=st.lists(_TEXTS, max_size=4))
@pytest.mark.parametrize("ending", ["json", "yaml"])
def test_round_trips_keep_every_bit(
    tmp_path_factory: pytest.TempPathFactory, ending: str, values: dict[str, float],
    names: list[str],
) -> None:  # fmt: skip
    case = Case("slider_crank", "run", parameters=values, run={"quantities": names})
    path = tmp_path_factory.getbasetemp() / f"round.{ending}"
    found = load_case(case.save(path))
    for name, value in values.items():
        kept = found.parameters[name]
        assert type(kept) is type(value)
        assert float(kept).hex() == float(value).hex()
    assert found.run.get("quantities", []) == names
    jsonschema.validate(found.data, schema())


def test_a_scene_as_data(folder: Path) -> None:
    case = load_case(
        written(
            folder,
            """
model: cased.py
scene:
  name: pushed
  extends: swing
  effects: [kick]
  without: [damper]
  parameters: {length: 800 mm}
  start: {bob.omega: 60 rpm}
  outputs: [energy]
  until: {over: "bob.phi > 90 deg"}
run: {t_end: 3}
""",
        )
    )
    jsonschema.validate(case.data, schema())
    r = case.analyse()
    assert r.ended_by == "over"
    assert r.q("bob.phi")[-1] == pytest.approx(math.pi / 2, abs=1e-12)
    assert r.parameters == {"length": 0.8}  # nothing depends on the damping
    assert r.v("bob.omega")[0] == pytest.approx(2 * math.pi, rel=1e-14)
    assert {*r.description.effects.names} == {"gravity", "kick"}


def test_a_declared_scene_as_data_is_that_scene(folder: Path) -> None:
    from codegen.reading.model_file import read_model

    scene = read_model(folder / "cased.py").model.scene("swing")
    case = Case(folder / "cased.py", scene, run={"t_end": 0.2})
    assert case.data["scene"] == {
        "name": "swing", "effects": ["gravity", "damper"],
        "start": {"bob.phi": 0.0, "bob.omega": 0.0},
    }  # fmt: skip
    found = load_case(case.save("swing.json")).analyse()
    expected = load(folder / "cased.py", "swing").simulate(0.2)
    np.testing.assert_array_equal(found.q("bob.phi"), expected.q("bob.phi"))


@pytest.mark.parametrize(
    ("text", "problems"),
    [
        (
            """model: cased.py
scenes: swing
run:
  t_ende: 1
  t_end: soon
parameters: [1]
start: {bob.phi: yes}
""",
            [
                r"line 2: There is no key 'scenes'; nearest: scene",
                r"line 4, run: There is no key 't_ende'; nearest: t_end",
                r"line 5, run\.t_end: 'soon' is no number",
                r"line 6, parameters: \[1\]: it must be a mapping",
                r"line 7, start\.bob\.phi: 'yes': it must be a finite number, or a text",
            ],
        ),
        ("scene: 3", ["line 1: model is missing", "line 1, scene: 3: it must be a text"]),
        ("model: x\nrun: {t_end: 3 kg}", [r"line 2, run\.t_end: 3 kilogram has the dimension"]),
        ("model: x\nanalysis: simulat", ["no word 'simulat'; nearest: simulate"]),
        ("model: x\nanalysis: equilibrium\nrun: {rtol: 1}", ["run: There is no key 'rtol'"]),
        ("model: x\nrun: {until: {a: b}}", [r'run\.until\.a: .b. is no condition; write "SERIES']),
        ("model: x\nrun: {t_eval: 1}", [r"run\.t_eval: 1: it must be a whole number from 2"]),
        ("model: x\nrun: {t_eval: [1, a]}", [r"run\.t_eval\[1\]: 'a' is no number"]),
        ("model: x\nscene: {nam: a}", ["scene: name is missing", "scene: There is no key 'nam'"]),
        ("model: x\nformat: linkwright case 2", ["format: There is no word 'linkwright case 2'"]),
        ("[1]", ["it must be a mapping, KEY: VALUE"]),
    ],
)  # fmt: skip
def test_all_problems_are_told_with_their_lines(
    folder: Path, text: str, problems: list[str]
) -> None:
    import re

    path = written(folder, text, "wrong.yaml")
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert len(caught.value.problems) == len(problems)
    for problem in problems:
        assert re.search(problem, str(caught.value)), (problem, str(caught.value))
    assert all(str(path) in problem for problem in caught.value.problems)


def test_what_the_machine_does_not_have_is_told_with_its_line(folder: Path) -> None:
    text = (
        "model: cased.py\nparameters:\n  lenght: 1\n  damping: 3 kg\nstart: {bob.fi: 1}\n"
        'guess: {bob.x: 3 rad}\nrun: {t_end: 1, until: {a: "bob.phi > 3 m"}}\n'
    )
    case = load_case(written(folder, text, "unfit.yaml"))
    machine = case.machine()
    with pytest.raises(InputError) as caught:
        case.words(machine)
    first, *others = caught.value.problems
    assert "unfit.yaml, line 3, parameters.lenght: There is no parameter 'lenght'; near" in first
    assert [problem.split(",")[1] for problem in others] == [
        " line 4",
        " line 5",
        " line 6",
        " line 7",
    ]
    with pytest.raises(InputError, match="t_end is missing"):
        Case(folder / "cased.py").analyse()
    rest = Case(folder / "cased.py", analysis="equilibrium", start={"bob.phi": 1.0})
    with pytest.raises(InputError, match="an equilibrium has no start values"):
        rest.analyse()


def test_other_analyses(folder: Path) -> None:
    rest = Case(
        folder / "cased.py", analysis="equilibrium", guess={"bob.phi": "-80 deg"},
        run={"method": "energy"},
    )  # fmt: skip
    assert rest.analyse().q("bob.phi")[-1] == pytest.approx(-math.pi / 2)


@pytest.mark.parametrize(
    "scene",
    [
        {"name": "a", "effects": ["gravty"]},
        {"name": "a", "until": {"b": "bob.z > 1"}},
        {"name": "a", "until": {"b": "bob.phi > 1 kg"}},
        {"name": "a", "start": {"bob.phi": "1 kg"}},
        {"name": "swing", "extends": "swing"},
        {"name": "1"},
    ],
)
def test_scenes_that_do_not_fit_the_model(folder: Path, scene: dict[str, Any]) -> None:
    text = json.dumps({"model": "cased.py", "scene": scene})
    path = written(folder, text, "scene.yaml")  # JSON is YAML
    with pytest.raises(InputError, match=r"scene\.yaml, line 1: .*scene( name)? '"):
        load_case(path).machine()


def test_arguments_of_other_kinds_are_refused() -> None:
    for words in ({"parameters": 3}, {"run": []}, {"scene": 3}, {"analysis": 3}, {"start": {1: 2}}):
        with pytest.raises(InputError):
            Case("slider_crank", **words)
    with pytest.raises(InputError, match=r"a file ending in \.yaml, \.yml, \.json"):
        Case("slider_crank").save("case.txt")
