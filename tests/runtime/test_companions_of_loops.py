"""Derivatives that a run asks for belong to the module that is loaded, in loops or written out."""

from pathlib import Path

import pytest

from codegen import build
from runtime import Outcome, load
from tests.codegen.workbench import write_model

PENDULUM = """
model = Model("pendulum", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.scene("swing", ["gravity"], start={bob.phi: 0.5})
"""


@pytest.mark.parametrize("unroll", ["never", "auto"])
def test_an_implicit_run_keeps_the_module_as_it_was_built(tmp_path: Path, unroll: str) -> None:
    model = write_model(tmp_path / "models", PENDULUM, "clock")
    report = build(model, out=tmp_path / "generated", compile=False, unroll=unroll)  # type: ignore[arg-type]
    text = report.paths[0].read_text()
    assert ("--unroll never" in text) == (unroll == "never")
    result = load(model, "swing", folder=tmp_path).simulate(0.1, method="bdf", progress=False)
    assert result.outcome is Outcome.OK, result.message
    assert report.paths[0].read_text() == text
