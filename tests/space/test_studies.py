"""Accuracy targets, work-precision diagrams, rankings, saved results and long chains in space."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.driver import build
from codegen.files.generated_modules import import_generated
from runtime import load, load_result
from runtime.studies.effect_ranking import matters
from runtime.studies.work_precision import accuracy
from tests.space.machines import DOWN


def rod() -> Model:
    model = Model("braked_rod", space=True, gravity=DOWN)
    body = model.body("rod", 2.0, (0.3, 0.5, 0.3), at=(0.1, 0.05, -0.5))
    model.spherical("O", model.ground, body, at=(0, 0, 0))
    for name, share in (("brake", 0.3), ("breath", 1e-7)):
        model.torque(name, body, tuple(-share * w for w in body.omega), frame="body")
    start = {"rod.omega_x": 3.0, "rod.omega_z": 4.0}
    model.scene("swing", ["gravity", "brake", "breath"], start=start)
    return model


@pytest.fixture(scope="module")
def machine(workshop: Path) -> Any:
    return load(rod(), folder=workshop)


def test_an_accuracy_is_reached(machine: Any) -> None:
    exact = machine.simulate(2.0, 21, rtol=1e-13, progress=False)
    names = ("rod.e1", "rod.omega_x", "O.fz")
    for target in (1e-5, 1e-8):
        found = machine.simulate(2.0, 21, accuracy=target, quantities=names, progress=False)
        for name in names:
            r = exact[name]
            size = 1.0 if name == "rod.e1" else np.abs(r).max()
            assert (np.abs(found[name] - r) / (size + np.abs(r))).max() < target
        assert found.accuracy.estimated <= target


def test_a_work_precision_diagram(workshop: Path) -> None:
    study = accuracy(
        rod(), t_end=0.5, methods=("dop853", "radau5"), rtols=(1e-4, 1e-8), quick=True,
        generated=workshop,
    )  # fmt: skip
    for line in study.lines:
        assert not line.refused
        loose, tight = (point.errors.worst for point in line.points)
        assert tight < 1e-7
        assert tight < loose < 1e-2


def test_a_ranking_of_effects(workshop: Path) -> None:
    found = matters(rod(), asked="range:rod.z", t_end=1.0, error=1e-3, generated=workshop)
    assert found["gravity"].relative > 1e-2 < found["brake"].relative
    assert found["breath"].relative < 1e-5
    assert found.proposal.left_out == ("breath",)


def test_results_are_saved_loaded_and_continued(machine: Any, tmp_path: Path) -> None:
    t = np.linspace(0.0, 2.0, 21)
    whole = machine.simulate(2.0, t, rtol=1e-11, progress=False)
    half = machine.simulate(1.0, t[:11], rtol=1e-11, progress=False)
    loaded = load_result(half.save(tmp_path / "half.nc"))
    assert_allclose(loaded["rod.omega_x"], half["rod.omega_x"], rtol=0.0, atol=0.0)
    assert_allclose(loaded.rotation("rod"), half.rotation("rod"), rtol=0.0, atol=0.0)
    rest = machine.simulate(2.0, t[10:], t_start=1.0, start=loaded, rtol=1e-11, progress=False)
    assert_allclose(rest.samples.q, whole.samples.q[10:], rtol=0.0, atol=1e-9)
    hanging = machine.equilibrium(progress=False)
    again = load_result(hanging.save(tmp_path / "rest.nc"), machine=machine)
    assert_allclose(again.rotation("rod"), hanging.rotation("rod"), rtol=0.0, atol=0.0)


def chain(links: int) -> Model:
    """Links of a table of lengths and masses, with ball joints."""
    model = Model(f"chain_{links}", space=True, gravity=DOWN)
    table = [(0.1 + 0.01 * (k % 3), 0.2 + 0.05 * (k % 4)) for k in range(links)]
    last, x = model.ground.at(0, 0, 0), 0.0
    for k, (length, mass) in enumerate(table):
        moment = mass * length**2 / 12
        link = model.body(f"link_{k}", mass, (1e-4, moment, moment), at=(x + length / 2, 0, 0))
        model.spherical(f"S{k}", last, link.at(-length / 2, 0, 0))
        last, x = link.at(length / 2, 0, 0), x + length
    model.scene("fall", ["gravity"], start={"link_0.omega_z": 1.0})
    return model


def test_kernels_in_loops_have_the_values_of_those_written_out(tmp_path: Path) -> None:
    links, answers = 6, []
    random = np.random.default_rng(1)
    q, v = random.normal(size=(2, 7 * links))
    for k in range(links):
        q[7 * k + 3 : 7 * k + 7] /= np.linalg.norm(q[7 * k + 3 : 7 * k + 7])
    for unroll in ("never", "always"):
        (scene,) = build(chain(links), out=tmp_path / unroll, compile=False, unroll=unroll).scenes
        assert ("for k in range(" in scene.text) is (unroll == "never")
        module = import_generated(scene.path, scene.text)
        p = np.zeros(len(module.PARAMETERS) + len(module.CONSTANTS))
        module.constants.py_func(p)
        a, lam = np.zeros(7 * links), np.zeros(4 * links)
        module.accelerations.py_func(0.0, q, v, p, np.zeros(0, np.int64), a, lam)
        dq, dv = np.zeros((2, 7 * links))
        module.correction.py_func(0.0, q, v, p, np.ones(7 * links), dq, dv)
        answers.append(np.concatenate([a, lam, dq, dv]))
    size = np.abs(answers[1]).max()
    assert_allclose(answers[0], answers[1], rtol=1e-10, atol=1e-12 * size)
