"""The driver: what it writes where, when it writes nothing, and how it survives company."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from codegen import build
from codegen.errors import GeneratedFileError, InputError
from codegen.files.generated_modules import check_signature, import_generated
from codegen.generated_files.generated_file import write_if_changed
from tests.codegen.workbench import write_model

PENDULUM = """
model = Model("pendulum", gravity=(0, -9.81))
m = model.parameter("m", 2.0, unit="kg")
bob = model.body("bob", mass=m, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.scene("swing", ["gravity"], start={bob.phi: 0.5})
model.scene("moon", [], start={bob.phi: 0.5})
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    return write_model(tmp_path / "models", PENDULUM, "clock")


def built(model: Path, out: Path, **options: object) -> object:
    return build(model, out=out, compile=False, **options)


def test_unchanged_model_writes_nothing(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "generated"
    first = built(model, out)
    assert [s.changed for s in first.scenes] == [True, True]
    assert [p.name for p in first.paths] == ["clock__swing.py", "clock__moon.py"]
    stamps = [path.stat().st_mtime_ns for path in first.paths]
    time.sleep(0.02)
    again = built(model, out)
    assert [s.changed for s in again.scenes] == [False, False]
    assert [path.stat().st_mtime_ns for path in again.paths] == stamps
    assert sorted(p.name for p in out.glob("*.py")) == ["clock__moon.py", "clock__swing.py"]


def test_only_the_scenes_that_changed_are_written(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "generated"
    built(model, out, scene="swing")
    report = built(model, out)
    assert {s.scene: s.changed for s in report.scenes} == {"swing": False, "moon": True}


def test_edit_in_the_same_second_is_seen(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    out = tmp_path / "generated"
    for mass in ("2.0", "3.0", "4.0"):
        model.write_text(model.read_text().replace('"m", 2.0', f'"m", {mass}'))
        path = built(model, out, scene="swing").paths[0]
        assert f'("m", {mass}, "kg", "positive")' in path.read_text()
        model.write_text(model.read_text().replace(f'"m", {mass}', '"m", 2.0'))
    assert not list(model.parent.rglob("*.pyc"))


def test_edited_helper_and_helpers_of_one_name(tmp_path: Path) -> None:
    texts = []
    for folder, length in (("one", 1.0), ("two", 2.0), ("two", 3.0)):
        path = write_model(
            tmp_path / folder, "from sizes import length\n" + PENDULUM.replace("-1", "-length")
        )
        (path.parent / "sizes.py").write_text(f"length = {length}\n")
        texts.append(built(path, tmp_path / "generated", scene="swing").paths[0].read_text())
        assert "sizes" not in sys.modules
    for text, length in zip(texts, ("crank", "2.0", "3.0"), strict=True):
        sources = text[text.index("SOURCES") :].partition(")\n)")[0]
        assert "sizes.py" in sources
        products = (f"{length} * sin_bob_phi", f"sin_bob_phi * {length}")
        assert length == "crank" or any(product in text for product in products)


def test_modules_whose_file_is_a_path_object_do_not_stop_a_build(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    odd = ModuleType("odd")
    odd.__file__ = Path(tmp_path / "odd.py")  # type: ignore[assignment]
    monkeypatch.setitem(sys.modules, "odd", odd)
    assert built(model, tmp_path / "generated", scene="swing").paths[0].is_file()


def test_check_finds_what_is_stale_and_writes_nothing(model: Path, tmp_path: Path) -> None:
    """That the library's own files are not stale, `make check` asks, as a step of `.ci/run`."""
    out = tmp_path / "generated"
    assert built(model, out, check=True).stale == (out / "clock__swing.py", out / "clock__moon.py")
    assert not out.exists()
    paths = built(model, out).paths
    assert built(model, out, check=True).stale == ()
    paths[1].write_text(paths[1].read_text() + "# by hand\n")
    assert built(model, out, check=True).stale == (paths[1],)
    assert paths[1].read_text().endswith("# by hand\n")


def test_comment_in_the_model_makes_its_files_stale(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "generated"
    built(model, out)
    before = (out / "clock__moon.py").read_text()
    model.write_text(model.read_text() + "# a comment\n")
    assert len(built(model, out, check=True).stale) == 2
    built(model, out)
    after = (out / "clock__moon.py").read_text()
    same = [line for line in before.splitlines() if "DECLARATION_SHA256" in line]
    assert same == [line for line in after.splitlines() if "DECLARATION_SHA256" in line]


def test_other_defaults_get_files_of_their_own(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "generated"
    plain = built(model, out, scene="swing").paths[0]
    heavy = built(model, out, scene="swing", settings={"m": 9.0}).paths[0]
    assert plain != heavy
    assert heavy.name.startswith("clock__swing__")
    assert '("m", 9.0, "kg", "positive")' in heavy.read_text()
    assert "--set m=9.0" in heavy.read_text()
    assert built(model, out, scene="swing", settings={"m": 9.0}).paths == (heavy,)


def test_sources_are_named_from_the_folder_of_the_project(model: Path, tmp_path: Path) -> None:
    inside = built(model, tmp_path / "generated", scene="swing").paths[0].read_text()
    assert '("models/clock.py", "' in inside
    assert "python -m codegen build models/clock.py --scene swing" in inside
    outside = built(model, tmp_path / "elsewhere" / "deep" / "down", scene="swing").paths[0]
    assert f'"{model.as_posix()}"' in outside.read_text()


def test_users_models_build_into_the_folder_they_work_in(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    report = build(model, compile=False)
    assert [p.resolve().parent for p in report.paths] == [work / "generated"] * 2


def test_bare_name_means_the_models_here_first(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert build("clock", compile=False).scenes[0].model == "pendulum"
    report = build("slider_crank", scene="kinematics", out=tmp_path / "out", compile=False)
    assert report.scenes[0].model == "slider_crank"


def test_stages_are_announced_and_timed(model: Path, tmp_path: Path) -> None:
    lines: list[str] = []
    report = build(model, scene="swing", out=tmp_path / "generated", progress=lines.append)
    stages = ["read", "derive", "examine", "lower", "emit", "compile"]
    (scene,) = report.scenes
    assert list(scene.seconds) == stages
    assert all(seconds >= 0 for seconds in scene.seconds.values())
    for stage in stages:
        assert any(stage in line for line in lines)
    module = import_generated(scene.path)
    assert module.accelerations.address
    assert (scene.coordinates, scene.constraints, scene.degrees_of_freedom) == (3, 2, 1)
    assert dict(module.OPERATIONS) == scene.operations


def test_two_builds_at_once_write_one_file(model: Path, tmp_path: Path, root: Path) -> None:
    out = tmp_path / "generated"
    code = (
        "import sys; from codegen import build; build(sys.argv[1], out=sys.argv[2], compile=False)"
    )
    running = [
        subprocess.Popen(
            [sys.executable, "-c", code, str(model), str(out)],
            env={**os.environ, "PYTHONPATH": str(root)},
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    for process in running:
        _, complaint = process.communicate(timeout=60)
        assert process.returncode == 0, complaint
    assert sorted(p.name for p in out.glob("*.py")) == ["clock__moon.py", "clock__swing.py"]
    for path in out.glob("*.py"):
        check_signature(path, path.read_text(), "again")
    assert not any(s.changed for s in built(model, out).scenes)


def test_folder_that_cannot_be_written(model: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(
            GeneratedFileError, match=r"cannot write .*choose another folder with --out"
        ):
            built(model, out)


def test_failed_write_leaves_the_old_file(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "generated"
    path = built(model, out, scene="swing").paths[0]
    before = path.read_bytes()
    model.write_text(model.read_text().replace("2.0", "5.0"))

    def refuse(self: Path, target: Path) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(GeneratedFileError, match="No space left on device"):
        built(model, out, scene="swing")
    assert path.read_bytes() == before
    assert [p for p in out.iterdir() if p.is_file()] == [path]


def test_second_scene_that_is_wrong_keeps_the_first_from_being_written(tmp_path: Path) -> None:
    text = PENDULUM + 'model.absolute("stop", bob, "x", 0.5)\nmodel.driver("d", bob.phi, 1 + t)\n'
    text += 'model.scene("locked", drivers=["d"])\n'
    path = write_model(tmp_path / "models", text, "clock")
    with pytest.raises(InputError, match=r"redundant: d\.phi"):
        built(path, tmp_path / "generated")
    assert not (tmp_path / "generated").exists()


def test_reports_are_plain_data(model: Path, tmp_path: Path) -> None:
    from dataclasses import asdict

    (scene,) = built(model, tmp_path / "generated", scene="moon").scenes
    record = asdict(scene)
    record["path"] = str(record["path"])
    assert json.loads(json.dumps(record))["left_out"] == ["gravity"]


def test_everybody_may_read_a_generated_file_whatever_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        assert write_if_changed(tmp_path / "a.py", "A = 1\n")
    finally:
        os.umask(before)
    assert (tmp_path / "a.py").stat().st_mode & 0o777 == 0o644


@pytest.mark.parametrize("unroll", ["x", "Never", "", 7])
def test_a_wrong_choice_of_loops_is_named_before_anything_is_built(
    model: Path, tmp_path: Path, unroll: object
) -> None:
    with pytest.raises(InputError, match="one of 'auto', 'always', 'never'") as raised:
        built(model, tmp_path / "generated", unroll=unroll)
    assert repr(unroll) in str(raised.value)
    assert not (tmp_path / "generated").exists()
