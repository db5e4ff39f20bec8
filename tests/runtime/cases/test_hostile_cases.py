"""Cases from outside: nothing in them is executed, and what is wrong with them is told soon."""

import json
import re
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from codegen.errors import InputError
from codegen.readers.quantities import FORM, UnitError, read_condition
from linkwright.cli.options import Request
from runtime import load_case


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """What is wrong with the text of a case, which leaves no mark."""

    def read(text: str | bytes, ending: str = "yaml") -> str:
        path = tmp_path / f"case.{ending}"
        path.write_bytes(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
        monkeypatch.chdir(tmp_path)
        with pytest.raises(InputError) as caught:
            load_case(path)
        assert not (tmp_path / "mark").exists()
        return str(caught.value)

    return read


@pytest.mark.parametrize(
    "tag",
    [
        "!!python/object/apply:os.system [touch mark]",
        "!!python/object/new:os.system [touch mark]",
        "!!python/name:os.system",
        "!!python/module:os",
        "!!python/tuple [1]",
        "!run touch mark",
        "!!binary aGFsbG8=",
        "!!set {a}",
        "!!timestamp 2001-01-01",
    ],
)
@pytest.mark.parametrize("place", ["model: {}", "model: x\nparameters: {{a: {}}}", "{}: x"])
def test_tags_construct_nothing(read: Callable[..., str], tag: str, place: str) -> None:
    message = read(place.format(tag))
    assert re.search("is none of a case: it has data alone|is no YAML|is no word", message)


def test_tags_of_yaml_itself_are_read(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text('model: !!str 5\nparameters: {a: !!float 1, b: 1e-8, c: "1e-8"}\n')
    case = load_case(path)
    assert case.model == "5"
    assert case.parameters == {"a": 1.0, "b": 1e-8, "c": "1e-8"}


@pytest.mark.parametrize(
    "value", ["on", "0x10", "1:30", "1_000", ".nan", ".inf", "2001-01-01", "~", "007kg"]
)
def test_words_of_older_yaml_are_no_numbers(read: Callable[..., str], value: str) -> None:
    message = read(f"model: x\nrun: {{rtol: {value}}}")
    assert "line 2, run.rtol: " in message
    assert "it must be a finite number" in message


def test_aliases_are_bounded(read: Callable[..., str]) -> None:
    laughs = ["a: &a [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    for older, newer in pairwise("abcdefghi"):
        laughs.append(f"{newer}: &{newer} [{', '.join([f'*{older}'] * 9)}]")
    assert "it has more than 100000 values, aliases written out" in read("\n".join(laughs))
    assert "in one another" in read("model: &a [*a]")


@pytest.mark.parametrize("ending", ["yaml", "json"])
@pytest.mark.parametrize(
    "text", ["[" * 100_000, "[" * 60 + "]" * 60, '{"a":' * 40 + "1" + "}" * 40]
)
def test_depth_is_bounded(read: Callable[..., str], ending: str, text: str) -> None:
    message = read(text, ending)
    form = "in one another|too deep|the file is no|must be a mapping|There is no key"
    assert re.search(form, message)


@pytest.mark.parametrize(
    ("text", "ending", "message"),
    [
        ("model: x\nmodel: y", "yaml", r"line 2: 'model' stands twice"),
        ('{"model": "x", "model": "y"}', "json", "'model' stands twice"),
        ("model: x\n<<: {scene: a}", "yaml", "There is no key '<<'"),
        ("1: x", "yaml", "the key '1' is no word"),
        ("? [a]\n: x", "yaml", "is no word"),
        ("model: x\n---\nmodel: y", "yaml", "line 2: "),
        ("model: [", "yaml", "the file is no YAML"),
        ("", "yaml", "the file is empty"),
        ("", "json", "the file is no JSON"),
        ('{"model": NaN}', "json", "nan: it must be a text"),
        ('{"model": "x", "run": {"rtol": 1e999}}', "json", "it must be a finite number"),
        (f'{{"model": "x", "run": {{"rtol": {"9" * 5000}}}}}', "json", "is no JSON"),
        (f"model: x\nrun: {{rtol: {'9' * 5000}}}", "yaml", "line 2: "),
        (f"model: x\nrun: {{rtol: {'9' * 400}}}", "yaml", "beyond all floats"),
        (f"model: x\nrun: {{max_steps: {2**62 + 1}}}", "yaml", "a whole number up to 4.61169e+18"),
        (b"\xff\xfe", "yaml", "no text in UTF-8"),
        (b"model: \x00", "yaml", "is no YAML"),
        ('{"model": "x", "start": {"a": "3\\u0085m"}}', "json", "characters that print"),
        ('{"model": "x", "run": {"until": {"a": "b\\u0085 > 3"}}}', "json", "that print"),
        ('{"model": "\\ud800"}', "json", "a text of 1 to 4096 characters that print"),
        (f"model: {'x' * 5000}", "yaml", "a text of 1 to 4096 characters"),
        ("#" + "x" * (1 << 20), "yaml", "more than 1 MiB"),
        ("model: x", "txt", "a file ending in .yaml, .yml, .json"),
    ],
)
def test_what_is_no_case(read: Callable[..., str], text: str, ending: str, message: str) -> None:
    assert message in read(text, ending)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('touch mark') > 3",
        "bob.phi > __import__('os').system('touch mark')",
        "bob.phi > 3 if __import__('os') else 4",
        "bob.phi > 1 > 0",
        "bob.phi",
        "> 3",
    ],
)
def test_conditions_are_names_and_numbers(
    read: Callable[..., str], tmp_path: Path, text: str
) -> None:
    """A call is at best the name of a series, which no machine has."""
    case = f'model: x\nrun: {{t_end: 1, until: {{a: "{text}"}}}}\n'
    if not text.startswith("__import__"):
        assert "line 2, run.until.a" in read(case)
        return
    (tmp_path / "until.yaml").write_text(case)
    assert load_case(tmp_path / "until.yaml").run["until"]["a"] == text
    assert not (tmp_path / "mark").exists()


def test_units_are_no_expressions(tmp_path: Path) -> None:
    from codegen.readers.quantities import UnitError, number_in

    for text in ("3 __import__('os')", "3 (1).real", "3 m**m", "3 m;m", "3 " + "m " * 100):
        with pytest.raises(UnitError):
            number_in(text, "m")


def test_reading_loads_no_model(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("raise SystemExit('executed')")
    (tmp_path / "case.yaml").write_text("model: model.py\nscene: {name: a}\n")
    before = {*sys.modules}
    case = load_case(tmp_path / "case.yaml")
    assert "model.py" in repr(case)
    assert not {name for name in {*sys.modules} - before if name.startswith("codegen.model")}


def test_yaml_without_its_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "case.yaml").write_text("model: x\n")
    (tmp_path / "case.json").write_text('{"model": "x"}')
    monkeypatch.setitem(sys.modules, "yaml", None)
    with pytest.raises(InputError, match=r"YAML needs the library PyYAML.*linkwright\[files\]"):
        load_case(tmp_path / "case.yaml")
    assert load_case(tmp_path / "case.json").model == "x"


def test_conditions_of_many_spaces_are_read_at_once(read: Callable[..., str]) -> None:
    """With a form that fits in several ways, this would take hours."""
    gap = " " * 1300
    for text in (f"{gap}a>{gap}b{gap}<", f"{gap}a{gap}", f"a>{gap}"):
        assert "is no condition" in read(
            json.dumps({"model": "x", "run": {"until": {"a": text}}}), "json"
        )
        assert not re.search(FORM, text)
        with pytest.raises(InputError, match="--until"):
            Request("x", run={"until": [f"{gap}a{gap}:{text}"]}).words()
    assert read_condition(f"{gap}a b{gap}<{gap}3 mm{gap}") == ("a b", "<", "3 mm")
    assert read_condition("a <= -3 mm") == ("a", "<", "-3 mm")
    with pytest.raises(UnitError, match="is no condition"):
        read_condition("a >=")


@pytest.mark.parametrize("unit", ["m^(1/0)", "m^(1/00)", "kg m**(2/0)"])
def test_exponents_without_a_value(read: Callable[..., str], unit: str) -> None:
    message = read(json.dumps({"model": "x", "parameters": {"l": f"1 {unit}"}}), "json")
    assert "is no unit" in message
