"""Files that go with a scene's own: which are written, kept up to date, and refused."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import codegen.driver
from codegen import build
from codegen.errors import SceneError
from codegen.files.generated_modules import check_signature, companion_path
from linkwright.cli.application import app
from tests.codegen.workbench import write_model

PENDULUM = """
model = Model("pendulum", gravity=(0, -9.81))
m = model.parameter("m", 2.0, unit="kg")
bob = model.body("bob", mass=m, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.driver("turn", bob.phi, t)
model.scene("swing", ["gravity"], start={bob.phi: 0.5})
model.scene("moon", [], start={bob.phi: 0.5})
model.scene("turning", drivers=["turn"], analysis="kinematics")
"""
DYNAMIC = ("clock__swing", "clock__moon")


@pytest.fixture
def model(tmp_path: Path) -> Path:
    return write_model(tmp_path / "models", PENDULUM, "clock")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "generated"


def built(model: Path, out: Path, **options: object) -> object:
    return build(model, out=out, compile=False, **options)


def written(out: Path) -> set[str]:
    return {path.stem for path in out.glob("*__tangents.py")}


def test_written_only_where_asked_for(model: Path, out: Path) -> None:
    plain = built(model, out)
    assert not written(out)
    assert [s.tangents for s in plain.scenes] == [None] * 3
    before = [path.read_bytes() for path in plain.paths]
    report = built(model, out, scene="swing", tangents=True)
    assert written(out) == {"clock__swing__tangents"}
    assert report.paths == plain.paths[:1]
    assert [path.read_bytes() for path in plain.paths] == before
    made = report.scenes[0].tangents
    assert (made.path, made.changed) == (companion_path(report.paths[0], "tangents"), True)
    assert set(made.operations) == {"accelerations_tangent", "correction_tangent"}
    assert min(made.operations.values()) > 0
    assert "differentiate" in made.seconds
    assert not built(model, out, scene="swing", tangents=True).scenes[0].tangents.changed


def test_every_scene_with_masses_gets_one(model: Path, out: Path) -> None:
    report = built(model, out, tangents=True)
    assert written(out) == {f"{stem}__tangents" for stem in DYNAMIC}
    assert [bool(s.tangents) for s in report.scenes] == [True, True, False]


def test_what_exists_is_brought_up_to_date(model: Path, out: Path) -> None:
    built(model, out, scene="swing", tangents=True)
    model.write_text(model.read_text().replace('"m", 2.0', '"m", 3.0'))
    report = built(model, out)
    assert [bool(s.tangents) for s in report.scenes] == [True, False, False]
    assert report.scenes[0].tangents.changed
    assert (
        f'MODULE_SHA256 = "{report.scenes[0].digest}"' in report.scenes[0].tangents.path.read_text()
    )
    assert not report.stale


def test_check_covers_what_exists(model: Path, out: Path) -> None:
    main = built(model, out, tangents=True).paths
    assert built(model, out, check=True).stale == ()
    path = companion_path(main[1], "tangents")
    path.write_text(path.read_text() + "# by hand\n")
    assert built(model, out, check=True).stale == (path,)
    assert path.read_text().endswith("# by hand\n")
    path.unlink()
    assert built(model, out, check=True).stale == ()
    assert built(model, out, check=True, tangents=True).stale == (path,)
    model.write_text(model.read_text() + "# a comment\n")
    assert built(model, out, check=True).stale == (
        main[0],
        companion_path(main[0], "tangents"),
        *main[1:],
    )


def test_signed_and_told_how_to_be_built(model: Path, out: Path) -> None:
    (scene,) = built(model, out, scene="swing", tangents=True, settings={"m": 5.0}).scenes
    path = scene.tangents.path
    assert path == companion_path(scene.path, "tangents")
    assert path.stem == f"{scene.path.stem}__tangents"
    text = path.read_text()
    check_signature(path, text, "again")
    command = "python -m codegen build models/clock.py --scene swing --set m=5.0 --tangents"
    assert f"#     {command}\n" in text
    assert '("accelerations_tangent", ' in text[text.index("OPERATIONS") :]


@pytest.mark.parametrize("scene", ["turning", ["swing", "turning"]])
def test_kinematic_scene_is_refused_by_name(model: Path, out: Path, scene: object) -> None:
    with pytest.raises(SceneError, match="scene 'turning' is kinematic: no masses") as caught:
        built(model, out, scene=scene, tangents=True)
    assert len(caught.value.problems) == 1
    assert "without --tangents" in str(caught.value)
    assert not out.exists()


def test_model_with_nothing_to_differentiate_is_refused(tmp_path: Path, out: Path) -> None:
    text = "\n".join(line for line in PENDULUM.splitlines() if "start=" not in line)
    path = write_model(tmp_path / "models", text, "clock")
    with pytest.raises(SceneError, match="model 'pendulum', scene 'turning' is kinematic"):
        built(path, out, tangents=True)


def test_command_line(
    model: Path, tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(codegen.driver, "compile_modules", lambda paths: [0.0] * len(paths))
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> object:
        return CliRunner().invoke(app, [str(a) for a in ("build", model, *arguments)])

    first = run("--scene", "swing", "--tangents")
    assert first.exit_code == 0
    assert "clock__swing__tangents.py: written" in first.stdout
    assert "accelerations_tangent " in first.stdout
    assert "compile derivatives " in first.stdout
    answer = json.loads(run("--tangents", "--json").stdout)
    paths = [s["tangents"]["path"] for s in answer["scenes"] if s["tangents"]]
    assert [Path(p).stem for p in paths] == [f"{stem}__tangents" for stem in DYNAMIC]
    (out / "clock__moon__tangents.py").unlink()
    assert run("--check").exit_code == 0
    stale = run("--check", "--tangents")
    assert stale.exit_code == 1
    assert "clock__moon__tangents.py is missing or out of date" in stale.stderr
    assert "clock.py --tangents" in stale.stderr
    assert "clock__swing__reduced.py: written" in run("--scene", "swing", "--reduced").stdout
    stale = run("--check", "--reduced")
    assert stale.exit_code == 1
    assert "clock.py --reduced" in stale.stderr
    refused = run("--scene", "turning", "--tangents")
    assert refused.exit_code == 2
    assert "error: model 'pendulum', scene 'turning' is kinematic" in refused.stderr


def test_both_kinds_beside_each_other(model: Path, out: Path) -> None:
    (scene,) = built(model, out, scene="swing", reduced=True, tangents=True).scenes
    assert [made.title for made in scene.companions] == ["derivatives", "reduced"]
    path = companion_path(scene.path, "reduced")
    assert scene.reduced.path == path
    text = path.read_text()
    check_signature(path, text, "again")
    assert f'MODULE_SHA256 = "{scene.digest}"' in text
    assert 'FORMULATION = "reduced"' in text
    assert "KEPT = (2,)" in text
    command = "python -m codegen build models/clock.py --scene swing --reduced"
    assert f"#     {command}\n" in text
    assert {"accelerations", "expand", "accelerations_tangent"} <= set(scene.reduced.operations)
    assert built(model, out, check=True).stale == (
        *(out / f"clock__{name}.py" for name in ("moon", "turning")),
    )
    path.write_text(text + "# by hand\n")
    assert path in built(model, out, scene="swing", check=True).stale
    assert built(model, out, scene="swing").scenes[0].reduced.changed
    assert path.read_text() == text


def test_reduced_equations_of_a_scene_without_dynamics_are_refused(model: Path, out: Path) -> None:
    with pytest.raises(SceneError, match="scene 'turning' is not for dynamics") as caught:
        built(model, out, scene="turning", reduced=True)
    assert "without --reduced" in str(caught.value)
    report = built(model, out, reduced=True)
    assert [bool(s.reduced) for s in report.scenes] == [True, True, False]


HASHES = """
import hashlib
from pathlib import Path
from codegen import build
out = Path({out!r})
for name, scene in (("slider_crank", "compressor"), ("valve_lifter", "inverse_dynamics")):
    report = build(name, scene=scene, out=out, tangents=True, reduced=True, compile=False)
    for made in report.scenes[0].companions:
        print(made.digest, hashlib.sha256(made.path.read_bytes()).hexdigest())
"""


def test_text_does_not_depend_on_the_hash_seed(root: Path, tmp_path: Path) -> None:
    running = [
        subprocess.Popen(
            [sys.executable, "-c", HASHES.format(out=str(tmp_path / "one" / seed))],
            cwd=root,
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("0", "42")
    ]
    answers = [process.communicate(timeout=120)[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    lines = [line.split() for line in answers[0].splitlines()]
    assert len(lines) == 4
    assert all(told == found for told, found in lines)
    assert answers[0] == answers[1]
