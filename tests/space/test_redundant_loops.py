"""A loop in space whose rows repeat each other: by every method, beside an independent solution."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from models.space.bricard import bricard
from runtime import load
from runtime.core.outcomes import Outcome


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
