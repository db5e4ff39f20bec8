"""Mistakes that were once made: one test each."""

import sysconfig
from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest
import sympy
from sympy import Abs

from codegen import Model, build
from codegen.errors import ModelError
from codegen.files import library_folders
from codegen.files.library_folders import installed_folders
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes, with_settings
from tests.codegen.workbench import Interpreted, State, write_model


def scene_of(model: Model) -> Interpreted:
    model.scene("only", effects=model.effects, drivers=model.drivers)
    return Interpreted(model, "only")


def test_a_kink_inside_a_condition_acts_only_where_the_condition_holds() -> None:
    model = Model("stop")
    body = model.body("body", 1.0, 1.0)
    model.force("stop", on=body, fy=Abs(body.vy), when=body.y < 0)
    machine = scene_of(model)
    text = machine.text()
    assert "if mode_" in text
    from tests.codegen.workbench import python_functions

    force = python_functions(text)["applied_forces"]
    for y, vy in ((1.0, 1.0), (1.0, -1.0), (-1.0, 2.0), (-1.0, -2.0)):
        modes = [1 if -y > 0 else 0, 1 if vy > 0 else 0]
        if "body_vy" in machine.lowered.description.switches[0][1]:
            modes.reverse()
        out = [0.0] * 3
        force(0.0, [0.0, y, 0.0], [0.0, vy, 0.0], [], modes, out)
        assert out[1] == (abs(vy) if y < 0 else 0.0)


@pytest.mark.parametrize("axis", [(cos(pi), sin(pi)), (cos(2 * pi), sin(2 * pi)), (1.0, 1e-13)])
def test_a_tiny_entry_is_no_pivot(axis: tuple[float, float]) -> None:
    model = Model("crank")
    crank = model.body("crank", 200.0, 450.0)
    rod = model.body("rod", 35.0, 35.0)
    slider = model.body("slider", 25.0, 0.02)
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(2, 0), rod.at(-1.75, 0))
    model.revolute("C", rod.at(1.75, 0), slider.at(0, 0))
    model.translational("guide", model.ground, slider, axis=axis)
    model.torque("motor", on=crank, value=100.0)
    machine = scene_of(model)
    angle, beta = 0.7, -np.arcsin(2 * np.sin(0.7) / 3.5)
    x = 2 * np.cos(angle) + 3.5 * np.cos(beta)
    rod_x, rod_y = 2 * np.cos(angle) + 1.75 * np.cos(beta), np.sin(angle)
    q = np.array([0, 0, angle, rod_x, rod_y, beta, x, 0, 0.0])
    s = State(t=0.0, q=q, v=np.zeros(9))
    dense = machine.jacobian(s)
    masses = np.diag([200, 200, 450, 35, 35, 35, 25, 25, 0.02])
    system = np.block([[masses, dense.T], [dense, np.zeros((8, 8))]])
    right = np.zeros(17)
    right[2] = 100.0
    expected = np.linalg.solve(system, right)
    a, lam = machine.solution(s)
    np.testing.assert_allclose(np.concatenate([a, lam]), expected, rtol=1e-11, atol=1e-11)


def test_what_is_added_after_a_first_build_acts_in_the_default_scene() -> None:
    model = Model("growing")
    body = model.body("body", 1.0, 1.0)
    model.force("first", on=body, fx=1.0)
    (before,) = valid_scenes(model, None)
    model.force("second", on=body, fx=2.0)
    (after,) = valid_scenes(model, None)
    assert before.effects == ("first",)
    assert after.effects == ("first", "second")
    assert not model.scenes


def test_settings_of_one_build_stay_out_of_the_model() -> None:
    model = Model("set")
    length = model.parameter("length", 1.0, unit="m")
    model.body("body", 1.0, 1.0)
    model.scene("s", parameters={length: 2.0})
    changed = with_settings(model, {"length": 7.0})
    assert changed.parameters["length"].value == 7.0
    assert changed.scenes["s"].parameters == ()
    assert model.parameters["length"].value == 1.0
    assert model.scenes["s"].parameters == (("length", 2.0),)


@pytest.mark.parametrize("unit", ["", "m", "kg m^2", "N m", "N s/m", "1/s", "rad/s", "m/s/s", "Hz"])
def test_si_units_are_taken(unit: str) -> None:
    model = Model("si")
    model.parameter("c", 1.0, unit=unit)
    assert not model.problems


def test_points_take_quantities_also_in_expressions() -> None:
    from pint import get_application_registry

    u = get_application_registry()
    body = Model("m").body("body", 1.0, 1.0)
    assert body.at(100 * u.mm, 2 * u.cm).vx.subs(body.phi, 0) == body.vx - 0.02 * body.omega


def test_numbers_beyond_all_bounds_are_refused_by_name() -> None:
    model = Model("big")
    body = model.body("body", 1.0, 1.0)
    model.force("huge", on=body, fx=1e200 * sympy.exp(600) * body.x)
    with pytest.raises(ModelError, match="'huge' comes to inf"):
        scene_of(model)


def test_all_local_files_are_sources(tmp_path: Path) -> None:
    package = tmp_path / "parts"
    package.mkdir()
    (package / "__init__.py").write_text("from . import inner\n")
    (package / "inner.py").write_text("mass = 3.0\n")
    data = tmp_path / "data.json"
    data.write_text("{}")
    text = "from parts import inner\nmodel.body('a', inner.mass, 1)\n"
    text = f"model = Model('m')\n{text}model.depends_on({str(data)!r})\n"
    path = write_model(tmp_path, text)
    sources = [source for source, _ in read_model(path).sources]
    assert sources == [path, package / "__init__.py", package / "inner.py", data]


def test_packages_behind_a_symbolic_link_are_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = sysconfig.get_paths()
    link = tmp_path / "environment"
    link.symlink_to(Path(folders["purelib"]).resolve())
    linked = folders | {"purelib": str(link), "platlib": str(link)}
    monkeypatch.setattr(sysconfig, "get_paths", lambda: linked)
    monkeypatch.setattr(library_folders, "installed_folders", installed_folders.__wrapped__)
    path = write_model(tmp_path, "import sympy\nmodel = Model('m')\nmodel.body('a', 1, 1)\n")
    assert [source for source, _ in read_model(path).sources] == [path]


def test_a_missing_data_file_is_named() -> None:
    model = Model("m")
    model.depends_on("nowhere.json")
    assert model.problems[0].startswith("depends_on('nowhere.json'): there is no file ")


def test_a_report_carries_the_hash_of_its_text(tmp_path: Path) -> None:
    import hashlib

    path = write_model(tmp_path, "model = Model('m')\nmodel.body('a', 1, 1)\n")
    (scene,) = build(path, out=tmp_path / "generated", compile=False).scenes
    assert scene.digest == hashlib.sha256(scene.path.read_bytes()).hexdigest()
