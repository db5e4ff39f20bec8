"""A first run whose steps stability limits is followed by an implicit method."""

from pathlib import Path

import numpy as np
import pytest

from codegen.generated_files.generated_file import write_if_changed
from runtime import load
from runtime.machine_facade import Machine

TEXT = """
from codegen import Model

model = Model("damped_cart")
damping = model.parameter("damping", 0.0, unit="N*s/m")
cart = model.body("cart", mass=1.0, inertia=1.0)
model.translational("guide", model.ground, cart, axis=(1, 0))
model.spring("spring", model.ground.at(-2, 0), cart, 1.0, free_length=1.0)
model.force("drag", cart.at(0, 0), -damping * cart.vx)
model.scene("pulled", ["spring", "drag"], start={cart.x: 0.5, cart.vx: 0.0})
"""


T = np.linspace(0.0, 3.0, 61)


@pytest.fixture(scope="module")
def cart(workshop: Path) -> Machine:
    path = workshop / "models" / "damped_cart.py"
    write_if_changed(path, TEXT)
    machine = load(path, "pulled", folder=workshop)
    assert machine.mechanism.tangents  # built, so that the program may choose the method
    return machine


@pytest.mark.parametrize(
    ("damping", "target", "expected"),
    [(0.5, 1e-3, "dop853"), (30.0, 1e-3, "radau5"), (30.0, 1e-9, "dop853")],
)
def test_an_implicit_method_follows_where_steps_are_long_beside_the_fastest_decay(
    cart: Machine, damping: float, target: float, expected: str
) -> None:
    run = cart.simulate(3.0, T, accuracy=target, parameters={"damping": damping}, progress=False)
    found = run.accuracy
    assert [trial.method for trial in found.runs][:2] == ["auto", expected]
    assert found.runs[0].steps < 100
    lower, upper = np.roots([1.0, damping, 1.0])  # z'' + d z' + z = 0 with z = x + 1
    a, b = np.linalg.solve([[1.0, 1.0], [lower, upper]], [1.5, 0.0])
    exact = np.real(a * np.exp(lower * T) + b * np.exp(upper * T)) - 1.0
    size = {row.name: row.scale for row in found.quantities}["cart.x"]
    errors = np.abs(run.series("cart.x")[0] - exact) / (size + np.abs(exact))
    assert max(errors.max(), found.estimated) <= target
