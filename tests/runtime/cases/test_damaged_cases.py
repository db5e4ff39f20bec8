"""Damaged cases are read or refused in sentences; nothing else is raised.

python -m tests.runtime.cases.test_damaged_cases 20000    # a campaign
"""

import json
import random
import sys
import tempfile
from pathlib import Path

import jsonschema
import pytest

from codegen.errors import InputError
from runtime import load_case
from runtime.cases.fields import schema

_SOUND = """model: cased.py
scene: {name: a, extends: swing, without: [damper], until: {over: "bob.phi > 90 deg"}}
analysis: simulate
parameters: {length: 120 cm, damping: 1e-2}
start: &s {bob.phi: 30 deg, bob.omega: -15 rpm}
guess: *s
run: {t_end: 500 ms, t_eval: [0, 0.1], rtol: 1e-9, until: {low: bob.phi < -1}}
"""
_PIECES = [
    *("{", "}", "[", "]", ":", ": ", ",", "\n", "  ", "- ", "&a ", "*a ", "*s", "!!str ", "!", "|"),
    *(">", "#", "'", '"', "\\", "%", "@", "`", "~", "null", "true", "1e999", "-0.0", "\t", "é"),
    *("\u2028", "\x85", "\x00", "<<: *s", "? ", "---\n", "...\n", "0x1", "9" * 30, ""),
]


def damaged(seed: int, sound: str) -> str:
    """The text with up to four pieces put in, taken out or exchanged."""
    chance, text = random.Random(seed), sound
    for _ in range(chance.randint(1, 4)):
        first = chance.randrange(len(text) + 1)
        last = min(len(text), first + chance.choice((0, 0, 1, 1, 2, 5, 20)))
        text = text[:first] + chance.choice(_PIECES) + text[last:]
    return text


def read(text: str, ending: str, folder: Path) -> bool:
    """Whether the text is read; a case that is read fits the schema and is saved and read again."""
    path = folder / f"damaged.{ending}"
    path.write_text(text, encoding="utf-8")
    try:
        case = load_case(path)
    except InputError as error:
        strange = [problem for problem in error.problems if not problem.startswith(str(path))]
        if strange:
            raise
        return False
    jsonschema.validate(case.data, schema())
    assert load_case(case.save(folder / "saved.json")).data == case.data
    assert load_case(case.save(folder / "saved.yaml")).data == case.data
    return True


def campaign(seeds: range, folder: Path) -> dict[str, int]:
    """How many cases of each ending are read."""
    folder.joinpath("sound.yaml").write_text(_SOUND)
    as_json = json.dumps(load_case(folder / "sound.yaml").data, indent=1)
    sound = {"yaml": _SOUND, "json": as_json}
    return {
        ending: sum(read(damaged(seed, text), ending, folder) for seed in seeds)
        for ending, text in sound.items()
    }


def test_damaged_cases(tmp_path: Path) -> None:
    counts = campaign(range(150), tmp_path)
    assert 5 < counts["yaml"] < 145  # some are cases, some are none
    assert 5 < counts["json"] < 145


@pytest.mark.parametrize("ending", ["yaml", "json"])
def test_bytes_that_are_no_text(tmp_path: Path, ending: str) -> None:
    chance = random.Random(3)
    for _ in range(50):
        path = tmp_path / f"bytes.{ending}"
        path.write_bytes(chance.randbytes(chance.randint(0, 200)))
        with pytest.raises(InputError):
            load_case(path)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        sys.stdout.write(f"{campaign(range(int(sys.argv[1])), Path(name))}\n")
