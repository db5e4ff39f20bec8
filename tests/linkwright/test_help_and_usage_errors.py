"""Pages of help, their examples, and what is said of words that are wrong."""

import json
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner, Result

from linkwright.command_panels_and_examples import EXAMPLES, PANELS
from linkwright.commands import app

GROUP: Any = get_command(app)
LINES = [(name, line) for name, lines in EXAMPLES.items() for line in lines]


def run(*words: str) -> Result:
    return CliRunner().invoke(app, [*words], prog_name="linkwright")


def test_every_command_has_a_panel_a_line_and_an_example() -> None:
    listed = [name for names in PANELS.values() for name in names]
    assert len(listed) == len(set(listed))
    assert set(GROUP.commands) <= set(listed) & set(EXAMPLES)
    shown = run("--help").stdout
    for panel, names in PANELS.items():
        there = {name: line for name, line in names.items() if name in GROUP.commands}
        assert not there or f"─ {panel} ─" in shown
        assert all(f"{name} " in shown and line in shown for name, line in there.items())


@pytest.mark.parametrize("name", GROUP.commands)
def test_help_ends_in_examples(name: str) -> None:
    done = run(name, "--help")
    assert done.exit_code == 0
    _, _, tail = done.stdout.partition(" Examples\n")
    assert [line.strip() for line in tail.split("\n") if line] == [*EXAMPLES[name]]


@pytest.mark.parametrize(("name", "line"), LINES, ids=str)
def test_an_example_is_a_line_of_its_command(name: str, line: str) -> None:
    program, command, *words = line.split()
    assert program == "linkwright"
    assert name in ("", command)
    assert len(line) <= 90
    GROUP.commands[command].make_context(command, words)


def test_every_option_with_a_value_has_a_placeholder() -> None:
    bare = {
        (name, p.name)
        for name, command in GROUP.commands.items()
        for p in command.params
        if p.param_type_name == "option" and not p.is_flag and not p.metavar
    }
    assert not bare


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("smulate", "error: no command 'smulate'; did you mean simulate?"),
        ("xyz", "error: no command 'xyz'; --help lists those that there are"),
        ("simulate a --secne b", "error: no option --secne; did you mean --scene"),
        ("simulate a --xyz", "error: no option --xyz; --help lists those that there are"),
        ("simulate a", "error: missing option '--t-end'."),
        ("simulate a --t-end", "error: option '--t-end' requires an argument."),
        ("new", "error: missing argument 'NAME'."),
        ("simulate a b --t-end 1", "error: got unexpected extra argument"),
        ("simulate a --t-end 1 --points 1", "error: invalid value for '--points': "),
    ],
)
def test_wrong_words_are_answered_as_other_errors_are(words: str, sentence: str) -> None:
    done = run(*words.split())
    assert done.exit_code == 2
    assert done.stdout == ""
    first, *advice = done.stderr.splitlines()
    assert first.startswith(sentence)
    if words.startswith("simulate") and not words.endswith("--t-end"):
        assert advice == [
            f"  Example: {EXAMPLES['simulate'][0]}",
            "  All options: linkwright simulate --help",
        ]


def test_wrong_words_with_json_are_one_object() -> None:
    done = run("simulate", "a", "--json")
    assert json.loads(done.stdout) == {
        "ok": False,
        "status": 2,
        "problems": ["missing option '--t-end'."],
    }


def test_wrong_input_of_the_compiler_with_json_is_one_object(tmp_path: Any) -> None:
    done = run("build", str(tmp_path / "nothing.py"), "--json")
    answer = json.loads(done.stdout)
    assert (done.exit_code, answer["ok"], answer["status"]) == (2, False, 2)
    assert "nothing.py" in answer["problems"][0]


def test_no_words_are_answered_with_the_help() -> None:
    done = run()
    assert done.exit_code == 2
    assert "Which effects does a quantity need?" in done.stdout


class TestOnlyModel:
    """A model that is not given is the only one of the working folder."""

    def test_it_is_taken(self, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "stone.py").write_text('from linkwright import Model\nmodel = Model("stone")\n')
        (tmp_path / "plot.py").write_text("print()\n")
        done = run("build")
        assert done.exit_code == 2
        assert "error: model 'stone' has no body" in done.stderr

    def test_there_is_none(self, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        done = run("simulate", "--t-end", "1", "--json")
        assert done.exit_code == 2
        assert "no model is given, and this folder has none" in done.stderr
        assert json.loads(done.stdout)["ok"] is False

    def test_there_are_several(self, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        for name in ("a", "b"):
            (tmp_path / f"{name}.py").write_text("Model()")
        done = run("simulate", "--t-end", "1")
        assert done.exit_code == 2
        assert "this folder has several: a.py, b.py. Give one of them." in done.stderr
