"""The commands about declarations: new, list, check, draw."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import linkwright as lw
from linkwright.cli.application import app
from linkwright.cli.declarations import KINDS, template

WORDS = ("# A parameter", "# A guess", "# A scene", "frame of its body", "ffect", "bod", "oint")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return tmp_path


def run(*words: str) -> Result:
    return CliRunner().invoke(app, [*words])


def write(kind: str, *edits: tuple[str, str]) -> None:
    """A model to start from in `machine.py`, edited."""
    text = template(kind).replace("NAME", "machine")
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    Path("machine.py").write_text(text)


@pytest.mark.parametrize("kind", KINDS)
def test_a_template_is_written_sound_drawn_and_runs(kind: str, folder: Path) -> None:
    done = run("new", "machine", "--kind", kind)
    assert (done.exit_code, done.stderr) == (0, "")
    path = folder / "machine.py"
    text = path.read_text(encoding="utf-8")
    assert "NAME" not in text
    assert all(word in text for word in WORDS)
    head, *lines = done.stdout.splitlines()
    assert head.endswith("Next:")
    assert {"check", "draw", "simulate", "report"} <= {line.split()[1] for line in lines}
    for line in lines:
        command, _, question = line.strip().partition("  ")
        assert "machine.py" in command.split()
        assert command.startswith("linkwright ")
        assert question.strip().endswith("?")
        assert f"    {command}" in text

    done = run("check")  # the only model of the folder
    assert (done.exit_code, done.stderr) == (0, "")
    assert "1 degree of freedom; none redundant\n" in done.stdout
    assert "the joints close at t = 0, within " in done.stdout
    assert "No scene uses" not in done.stdout
    assert "Next: linkwright simulate machine.py --scene " in done.stdout
    done = run("draw", "--out", "machine.svg")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "Saved: machine.svg\n")
    picture = (folder / "machine.svg").read_text(encoding="utf-8")
    assert "machine, " in picture
    assert ">A</text>" in picture
    assert not (folder / "generated").exists()

    report = lw.build(path, compile=False)
    assert not [note for scene in report.scenes for note in scene.notes]
    m = lw.load(path)
    r = m.simulate(0.2)
    assert r.outcome == lw.Outcome.OK
    assert abs(r.v(m.coordinates[2].velocity)).max() > 0.1


def test_nothing_is_overwritten(folder: Path) -> None:
    (folder / "machine.py").write_text("mine")
    done = run("new", "machine.py")
    assert done.exit_code == 2
    assert "machine.py is there already" in done.stderr
    assert (folder / "machine.py").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("new 2x", "model name '2x' is no identifier"),
        ("new a/b", "model name 'a/b' is no identifier"),
        ("new x --kind fourbar", "of kind 'fourbar'; did you mean 'four-bar'?"),
        ("list nowhere", "'nowhere' is no folder; give the folder of some model files."),
        ("check nothing.py", "There is no model 'nothing.py'"),
        ("check machine.py --scene swin", "no scene 'swin'; did you mean 'swing'"),
        ("draw machine.py --out a.xyz", "--out a.xyz: a picture ends in .png, .svg or .pdf."),
        ("draw machine.py --out no/a.png", "no/a.png: the folder "),
        ("draw machine.py --scene swin --out a.png", "no scene 'swin'; did you mean 'swing'"),
        ("draw machine.py --set lenth=1 --out a.png", "did you mean 'length'?"),
        ("draw machine.py --t 0.25 --guesses --out a.png", "--guesses with --t"),
    ],
)
def test_wrong_words(words: str, sentence: str, folder: Path) -> None:
    write("pendulum")
    done = run(*words.split())
    assert done.exit_code == 2
    assert done.stderr.startswith("error: ")
    assert sentence in done.stderr
    assert [path.name for path in folder.iterdir()] == ["machine.py"]


def test_list_of_a_folder(folder: Path) -> None:
    run("new", "swing", "--kind", "pendulum")
    (folder / "plot.py").write_text("print()")
    (folder / "broken.py").write_text("Model(")
    done = run("list", str(folder))
    assert done.exit_code == 0
    lines = [line.split() for line in done.stdout.splitlines()]
    assert [line[0] for line in lines[1:] if line] == ["swing.py", "swing", "free_swing"]
    assert lines[1][1:4] == ["swing:", "a", "pendulum,"]
    assert " ".join(lines[3][1:4]) == "The same without"
    (model,) = json.loads(run("list", ".", "--json").stdout)["models"]
    assert (model["name"], model["path"]) == ("swing", "swing.py")
    assert [scene["name"] for scene in model["scenes"]] == ["swing", "free_swing"]


def test_list_has_this_folder_and_the_library(folder: Path) -> None:
    assert "linkwright new NAME" in run("list", ".").stderr
    run("new", "swing", "--kind", "pendulum")
    done = run("list")
    assert done.stdout.startswith("this folder\n  swing.py ")
    assert "the library\n  coil_spring " in done.stdout
    assert "the library, in space\n  space/bricard " in done.stdout
    assert "slider-crank compressor of Haug, Computer-Aided Kinematics" in " ".join(
        done.stdout.split()
    )


def test_templates_are_files_of_the_package(root: Path) -> None:
    files = {p.stem for p in (root / "linkwright" / "templates").glob("[!_]*.py")}
    assert files == {kind.replace("-", "_") for kind in KINDS}


def test_all_problems_are_lines_of_stderr() -> None:
    write("four-bar", ('effects=["gravity", "fric', 'effects=["gravty", "'),
          ('"AB", 0.10', '"AB", -0.10'))  # fmt: skip
    done = run("check", "machine.py")
    assert (done.exit_code, done.stdout) == (2, "")
    lines = done.stderr.splitlines()
    assert all(line.startswith("error: ") for line in lines)
    assert any("did you mean 'gravity'?" in line for line in lines)
    assert any("parameter 'AB' is -0.1 m" in line for line in lines)


def test_a_parameter_that_opens_the_joints() -> None:
    write("four-bar")
    words = ("check", "machine.py", "--scene", "swing", "--set", "AD=3")
    done = run(*words)
    assert done.exit_code == 2
    assert "error: machine/swing: the machine cannot be assembled" in done.stderr
    answer = json.loads(run(*words, "--json").stdout)
    assert (answer["ok"], answer["status"], len(answer["problems"])) == (False, 2, 1)


def test_json_of_a_sound_model() -> None:
    write("pendulum")
    answer: Any = json.loads(run("check", "machine.py", "--json").stdout)
    assert (answer["ok"], answer["model"], answer["unused"]) == (True, "machine", {})
    first, second = answer["scenes"]
    assert (first["scene"], first["degrees_of_freedom"]) == ("swing", 1)
    assert second["left_out"] == ["brake"]
    assert second["unused_parameters"] == ["damping"]
    assert first["gap"] < 1e-12


def test_a_check_and_a_picture_leave_no_file_beside_the_model(folder: Path) -> None:
    write("pendulum")
    assert run("check", "machine.py").exit_code == 0
    assert run("draw", "machine.py", "--out", "a.svg").exit_code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["a.svg", "machine.py"]


def test_options_change_the_picture(folder: Path) -> None:
    write("four-bar")
    pictures = set()
    for words in ([], ["--frames"], ["--dimensions"], ["--no-names"], ["--guesses"],
                  ["--set", "AD=0.32"], ["--scene", "driven"]):  # fmt: skip
        assert run("draw", "machine.py", *words, "--out", "a.svg").exit_code == 0
        pictures.add((folder / "a.svg").read_bytes())
    assert len(pictures) == 7


def test_a_picture_at_an_instant(folder: Path) -> None:
    """A quarter of a turn after the start, the crank of the driven machine points upwards."""
    write("four-bar")
    words = ("draw", "machine.py", "--scene", "driven", "--t", "0.25", "--out", "a.png")
    assert json.loads(run(*words, "--json").stdout) == {"ok": True, "saved": "a.png"}
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")


def test_endings_in_capitals(folder: Path) -> None:
    write("pendulum")
    for name, start in (("A.PNG", b"\x89PNG"), ("B.Svg", b"<?xml"), ("C.PDF", b"%PDF")):
        assert run("draw", "machine.py", "--out", name).exit_code == 0
        assert (folder / name).read_bytes().startswith(start)


def test_numbers_without_a_unit_are_printed_without_one() -> None:
    Path("bar.py").write_text(
        "from codegen import Model, t\n"
        'model = Model("bar", space=True)\n'
        'bar = model.body("bar", 1.0, (0.1, 0.1, 0.1), at=(0.1, 0, 0))\n'
        'hinge = model.revolute("A", model.ground, bar, at=(0, 0, 0), axis=(0, 0, 1))\n'
        'model.rotation_driver("drive", hinge, 2.0 + t)\n'
        'model.scene("run", drivers=["drive"])\n'
    )
    shown = run("check", "bar.py").stdout
    assert "bar.e3 0 → 0.8415, bar.e0 1 → 0.5403, bar.x 0.1 → -0.04161 m, and 1 more" in shown
    ends = run("kinematics", "bar.py", "--t-end", "1").stdout.splitlines()
    assert not [line for line in ends if line.endswith(" 1") and line.startswith("bar.")]
    assert any(line.startswith("bar.e3") for line in ends)


def test_machines_in_space_are_drawn_along_an_axis() -> None:
    write("pendulum")
    assert run("draw", "machine.py", "--view", "z", "--out", "a.svg").exit_code != 0
    Path("ball.py").write_text(
        "from codegen import Model\n"
        'model = Model("ball", space=True)\n'
        'model.body("ball", 1.0, (0.1, 0.2, 0.3), at=(0.1, 0, 0))\n'
    )
    pictures = set()
    for view in ("usual", "x", "z"):
        assert run("draw", "ball.py", "--view", view, "--out", "a.svg").exit_code == 0
        pictures.add(Path("a.svg").read_bytes())
    assert len(pictures) == 3
