"""What a build says about a model that is wrong, by both doors: the function and the command."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen import InputError, build
from linkwright.cli.application import app
from tests.codegen.workbench import write_model

HEAD = """
from pint import get_application_registry as units
model = Model("m", gravity=(0, -9.81))
a = model.body("a", mass=1.0, inertia=2.0)
b = model.body("b", mass=3.0, inertia=4.0)
k = model.parameter("k", 5.0, unit="N/m")
"""


def complaints(folder: Path, text: str, head: str = HEAD) -> list[str]:
    """Lines on stderr of a build that ends with status 2, having written nothing."""
    path = write_model(folder, head + text)
    out = folder / "out"
    answer = CliRunner().invoke(app, ["build", str(path), "--out", str(out)])
    assert answer.exit_code == 2, answer.output + repr(answer.exception)
    assert answer.stdout == ""
    assert not out.exists()
    assert sorted(p.name for p in folder.iterdir()) == [path.name]
    found = [line.removeprefix("error: ") for line in answer.stderr.splitlines()]
    with pytest.raises(InputError) as caught:
        build(path, out=out, compile=False)
    assert len(caught.value.problems) == len(set(caught.value.problems)) == len(found)
    return found


def check(found: list[str], expected: list[str]) -> None:
    for pattern in expected:
        assert any(re.search(pattern, line) for line in found), f"{pattern!r} not in {found}"
    assert len(found) == len(expected), found
