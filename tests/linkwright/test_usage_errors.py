"""Pages of help, their examples, and what is said of words that are wrong."""

import json
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner, Result

from linkwright.cli.application import app

GROUP: Any = get_command(app)
EXAMPLES = {
    name: command.epilog.split("\n\n")[1:]
    for name, command in {"": GROUP, **GROUP.commands}.items()
}
LINES = [(name, line) for name, lines in EXAMPLES.items() for line in lines]


def run(*words: str) -> Result:
    return CliRunner().invoke(app, [*words], prog_name="linkwright")


def test_every_command_has_a_panel_a_line_and_an_example(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    shown = run("--help").stdout
    for name, command in GROUP.commands.items():
        assert f"─ {command.rich_help_panel} ─" in shown
        assert f"{name} " in shown
        assert command.help.partition("\n")[0] in shown
        assert EXAMPLES[name]


@pytest.mark.parametrize("name", EXAMPLES)
def test_help_ends_in_examples(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    done = run(*([name] if name else []), "--help")
    assert done.exit_code == 0
    _, _, tail = done.stdout.partition(" Examples:")
    assert [line.strip() for line in tail.split("\n") if line.strip()] == EXAMPLES[name]


@pytest.mark.parametrize(("name", "line"), LINES, ids=str)
def test_an_example_is_a_line_of_its_command(name: str, line: str) -> None:
    program, command, *words = line.split()
    assert program == "linkwright"
    assert name in ("", command)
    assert len(line) <= 90
    GROUP.commands[command].make_context(command, words)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("smulate", "error: No such command 'smulate'. Did you mean 'simulate'?"),
        ("xyz", "error: No such command 'xyz'."),
        ("simulate a --secne b", "error: No such option: --secne (Possible options: "),
        ("simulate a --xyz", "error: No such option: --xyz"),
        ("simulate a", "error: Missing option '--t-end'."),
        ("simulate a --t-end", "error: Option '--t-end' requires an argument."),
        ("new", "error: Missing argument 'NAME'."),
        ("simulate a b --t-end 1", "error: Got unexpected extra argument"),
        ("simulate a --t-end 1 --points 1", "error: Invalid value for '--points': "),
        ("build a --unroll some", "error: Invalid value for '--unroll': Value error, "),
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


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("simulate a --json", "Missing option '--t-end'."),
        ("build nothing.py --json", "There is no model 'nothing.py'"),
    ],
)
def test_what_is_wrong_with_json_is_one_object(words: str, problem: str) -> None:
    done = run(*words.split())
    answer = json.loads(done.stdout)
    assert (done.exit_code, answer.pop("ok"), answer.pop("status")) == (2, False, 2)
    (told,) = answer.pop("problems")
    assert told.startswith(problem)
    assert not answer


NONSENSE = ("", "-", "-1", "nan", "1e400", "a\nb", "[red]x[/red]", "\udcff", "x" * 300, "=", "zz=1")


@pytest.mark.parametrize("name", sorted({*GROUP.commands} - {"precompile"}))  # it takes minutes
def test_nonsense_is_answered_in_sentences(
    name: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    options = [p.opts[0] for p in GROUP.commands[name].params if not getattr(p, "is_flag", True)]
    for word in NONSENSE:
        for words in ([word], *(["nowhere.py", option, word] for option in options)):
            done = run(name, *words)
            assert done.exit_code in (0, 1, 2), words
            assert isinstance(done.exception, SystemExit | None), words
            assert done.output.strip(), words
            assert "Traceback" not in done.output, words


def test_no_words_are_answered_with_the_help() -> None:
    done = run()
    assert done.exit_code == 2
    assert "Find the effects that a quantity needs" in done.stdout


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"stone": 'from linkwright import Model\nmodel = Model("stone")\n', "plot": "print()\n"},
         "error: model 'stone' has no body"),
        ({}, "no model is given, and this folder has none"),
        ({"a": "Model()", "b": "Model()"},
         "this folder has several: a.py, b.py. Give one of them."),
    ],
)  # fmt: skip
def test_a_model_that_is_not_given_is_the_only_one_of_the_folder(
    files: dict[str, str], message: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in files.items():
        (tmp_path / f"{name}.py").write_text(text)
    done = run("simulate", "--t-end", "1", "--json")
    assert done.exit_code == 2
    assert message in done.stderr
    assert json.loads(done.stdout)["ok"] is False
