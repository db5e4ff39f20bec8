"""The command `linkwright draw`."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from linkwright.cli.application import app
from linkwright.cli.completion import MODELS_TO_START_FROM as KINDS
from linkwright.cli.new_model import text_of


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> Result:
    return CliRunner().invoke(app, ["draw", *words])


@pytest.mark.parametrize("kind", KINDS)
def test_models_to_start_from_are_drawn(kind: str, folder: Path) -> None:
    (folder / "machine.py").write_text(text_of(kind, "machine"))
    done = run("--out", "machine.svg")  # of the only model of the folder
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "Saved: machine.svg\n")
    text = (folder / "machine.svg").read_text(encoding="utf-8")
    assert "machine, " in text
    assert ">A</text>" in text
    assert not (folder / "generated").exists()


def test_options_change_the_picture(folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("four-bar", "machine"))
    pictures = set()
    for words in ([], ["--frames"], ["--dimensions"], ["--no-names"], ["--guesses"],
                  ["--set", "AD=0.32"], ["--scene", "driven"]):  # fmt: skip
        assert run("machine.py", *words, "--out", "a.svg").exit_code == 0
        pictures.add((folder / "a.svg").read_bytes())
    assert len(pictures) == 7


def test_at_an_instant(folder: Path) -> None:
    """A quarter of a turn after the start, the crank of the driven machine points upwards."""
    (folder / "machine.py").write_text(text_of("four-bar", "machine"))
    done = run("machine.py", "--scene", "driven", "--t", "0.25", "--out", "a.png", "--json")
    assert json.loads(done.stdout) == {"ok": True, "saved": "a.png"}
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
    done = run("machine.py", "--scene", "driven", "--t", "0.25", "--guesses", "--out", "a.png")
    assert done.exit_code == 2
    assert "--guesses with --t" in done.stderr


def test_endings_in_capitals(folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("pendulum", "machine"))
    for name, start in (("A.PNG", b"\x89PNG"), ("B.Svg", b"<?xml"), ("C.PDF", b"%PDF")):
        assert run("machine.py", "--out", name).exit_code == 0
        assert (folder / name).read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--out", "a.xyz"], "--out a.xyz: a picture ends in .png, .svg or .pdf."),
        (["--out", "no/a.png"], "no/a.png: the folder "),
        (["--scene", "swin", "--out", "a.png"], "no scene 'swin'; did you mean 'swing'"),
        (["--set", "lenth=1", "--out", "a.png"], "did you mean 'length'?"),
    ],
)
def test_wrong_words(words: list[str], sentence: str, folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("pendulum", "machine"))
    done = run("machine.py", *words)
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert done.stderr.startswith("error: ")
    assert not [*folder.glob("a.*")]
