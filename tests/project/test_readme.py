"""The first minutes: what README and the pages tell a user to type is there."""

import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.main import get_command

from linkwright.cli.application import app
from runtime.results.export import table

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = [
    ROOT / "README.md",
    *(page for page in sorted((ROOT / "docs").rglob("*.md")) if "_build" not in page.parts),
]
LINE = re.compile(r"^linkwright .*$|`linkwright ([^`]*)`", re.MULTILINE)


def typed(page: Path) -> list[list[str]]:
    """The words after `linkwright` of every command line of a page, comments left out."""
    text = page.read_text(encoding="utf-8").replace(" --t-end T`", " --t-end 1`")
    lines = (match.group(1) or match.group() for match in LINE.finditer(text))
    words = (line.partition("  #")[0].removeprefix("linkwright ") for line in lines)
    return [shlex.split(line) for line in words]


COMMANDS = [(page.name, words) for page in PAGES for words in typed(page) if "..." not in words]


@pytest.mark.parametrize(("page", "words"), COMMANDS, ids=str)
def test_commands_are_there_with_these_options(page: str, words: list[str]) -> None:
    group: Any = get_command(app)
    if words[0] in ("COMMAND", *(name for p in group.params for name in p.opts), "--help"):
        return
    command = group.commands[words[0]]
    if len(words) > 1:
        incomplete = "MODEL" in words or any(word.endswith((".yaml", ".json")) for word in words)
        command.make_context(words[0], words[1:], resilient_parsing=incomplete)


def test_there_are_commands_to_look_at() -> None:
    names = {words[0] for page, words in COMMANDS if page == "README.md"}
    assert {"build", "explain", "simulate", "report", "matters", "--version"} <= names


def test_readme_answers_the_first_questions() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    first, _, rest = text.partition("## Two commands")
    assert "compiler for mechanisms in the plane" in first
    before, _, _ = rest.partition("## A machine in a page")
    assert "source .venv/bin/activate" in before
    assert "first simulation compiles the runtime, once" in before
    assert "from linkwright import Model, t  # t is the time, in s" in text
    assert "python -m codegen build" in text


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The pendulum of README, declared, loaded and run as it stands there."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").split("## A machine in a page")[1]
    declared, used, *_ = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    folder = tmp_path_factory.mktemp("first_minutes")
    (folder / "pendulum.py").write_text(declared, encoding="utf-8")
    names: dict[str, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(used, names)
        page = (ROOT / "docs" / "reference" / "kernels.md").read_text(encoding="utf-8")
        (example,) = re.findall(r"```\{code-cell\} python\n(.*?)```", page, re.DOTALL)
        exec(example, names)
        names["rest"] = names["m"].equilibrium(guess={"bob.phi": -1.0})
    return names


def test_the_page_of_results_names_the_columns(run: dict[str, Any]) -> None:
    page = (ROOT / "docs" / "reference" / "results.md").read_text(encoding="utf-8")
    named = {
        name for line in page.splitlines() for name in re.findall(r"`([^`]*? \[[^`]*\])`", line)
    }
    there = {*table(run["r"])}
    ours = {name for name in named if "bob" in name or "hinge" in name or "damper" in name}
    assert len(ours) >= 6
    assert "work(damper) [J]" in ours  # of scenes whose outputs name it
    assert ours - {"work(damper) [J]"} | {"time [s]", "kinetic energy [J]"} <= there


def test_the_page_of_results_names_calls_that_there_are(run: dict[str, Any]) -> None:
    """`r.path("tip")` was one of them."""
    page = (ROOT / "docs" / "reference" / "results.md").read_text(encoding="utf-8")
    called = set(re.findall(r"`r\.(\w+)\b", page))
    assert {"q", "point", "force", "length", "power", "events"} <= called
    assert all(hasattr(run["r"], word) for word in called)


def test_signs_are_those_of_the_page(run: dict[str, Any]) -> None:
    """The ground holds the bob up; the damper takes energy away."""
    assert run["rest"].reaction("hinge", "fy")[0] == pytest.approx(2.0 * 9.81, rel=1e-9)
    assert np.all(run["r"].power("damper") <= 0.0)
    assert run["r"].power("damper").min() < -0.1


def test_the_example_of_kernels_solves_the_equations_of_motion(run: dict[str, Any]) -> None:
    """At φ = 0 the bar lies level: φ̈ = -m g l / (J + m l²) for the length 1 m."""
    assert run["weak"] == 0
    assert run["a"][2] == pytest.approx(-2.0 * 9.81 / (0.1 + 2.0), rel=1e-12)
    assert_allclose(run["jacobian"] @ run["a"], 0.0, atol=1e-12)
