"""A loop in space whose rows repeat each other: by every method, beside an independent solution."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from models.space.bricard import bricard
from runtime import load
from runtime.core.outcomes import Outcome
from tests.space.machines import Z


def tracked() -> Model:
    """Bricard's linkage with the path of a pin."""
    model = bricard()
    model.track("pin", model.bodies["b2"].at(0, -0.5, 0))
    model.scene("followed", effects=["gravity", "pin"])
    return model


@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_bricards_linkage_moves_as_its_reference_does(
    method: str, root: Path, workshop: Path
) -> None:
    reference = np.genfromtxt(root / "tests/data/bricard.csv", delimiter=",", names=True)
    machine = load(tracked(), "followed", folder=workshop)
    run = machine.simulate(10.0, reference["t"], rtol=1e-9, method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert "Redundant: J6.g; the reactions of J1" in run.message
    for axis in "xyz":
        assert_allclose(run.point("pin", axis), reference[f"P3{axis}"], rtol=0, atol=1e-9)
    assert all(np.isfinite(run.reaction(f"J{k}", "fx")).all() for k in range(1, 7))


def four_bar() -> Any:
    """A four-bar of parallel axes, of whose last hinge three rows follow; its hinges count."""
    model: Any = Model("counting_four_bar", space=True, gravity=(0, -9.81, 0))
    pins = [(0, 0, 0), (0, 1, 0), (2, 1.2, 0), (2, 0, 0)]
    middles = (np.mean(pins[k : k + 2], axis=0).tolist() for k in range(3))
    bars = [model.body(f"b{k}", 1.0, (0.1, 0.1, 0.1), at=at) for k, at in enumerate(middles)]
    links = (model.ground, *bars, model.ground)
    hinges = [
        model.revolute(f"J{k}", *links[k : k + 2], at=at, axis=Z) for k, at in enumerate(pins)
    ]
    model.rotation_driver("drive", hinges[0], 3 * t)
    angles = [hinge.angle for hinge in hinges]
    for name, words in {"few": ["default"], "all": ["all"]}.items():
        model.scene(f"led_{name}", ["gravity"], ["drive"], outputs=[*words, *angles])
        model.scene(f"free_{name}", ["gravity"], outputs=[*words, angles[0]])
    model.scene("free_energy", ["gravity"], outputs=["energy", angles[0]])
    model.scene("free_doubled", ["gravity"], outputs={"doubled": 2 * angles[0]})
    return model


@pytest.mark.parametrize("few", ["led_few", "free_few", "free_energy", "free_doubled"])
def test_outputs_afterwards_where_hinges_count(few: str, workshop: Path) -> None:
    model, runs = four_bar(), []
    for scene in (few, few.partition("_")[0] + "_all"):
        machine = load(model, scene, folder=workshop)
        if scene.startswith("led"):
            runs.append(machine.inverse_dynamics(0.3, 4, progress=False))
        else:
            start = {"J0.rate": 2.0}
            runs.append(machine.simulate(0.3, 4, start=start, rtol=1e-10, progress=False))
    late, named = runs
    assert "Redundant: J3.z, J3.f, J3.g;" in late.message
    power = named.power("gravity")
    assert_allclose(late.power("gravity"), power, rtol=1e-9, atol=1e-12)
    assert power[-1] > 30.0
    wanted = named.wrench("J2", "b2")
    assert_allclose(late.wrench("J2", "b2"), wanted, rtol=0.0, atol=1e-7 * np.abs(wanted).max())
