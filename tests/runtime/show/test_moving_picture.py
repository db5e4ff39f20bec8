"""Pictures of results: joints at all instants, reactions where they act, joints that go."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.drawing.picture import Picture
from codegen.drawing.shapes import Pin, Reaction, Rod, places
from codegen.files.generated_modules import MARK, UNSIGNED, signed
from codegen.picture_at_start import declared_picture
from codegen.reading.model_file import read_model
from runtime import load
from runtime.mechanism.dense_equations import Equations
from runtime.show.pictures import moving_picture

MACHINES = [
    ("slider_crank", "compressor"), ("quick_return", "shaper"), ("gear_slider", "train_running"),
    ("rack_and_pinion", "running"), ("scotch_yoke", "rocking"),
    ("valve_lifter", "inverse_dynamics"),
]  # fmt: skip


def result_of(name: str, scene: str) -> Any:
    machine = load(name, scene)
    if machine.is_determined:
        return machine.inverse_dynamics([0.0, 0.03, 0.11], progress=False)
    return machine.simulate(0.2, 3, progress=False)


@pytest.mark.parametrize(("name", "scene"), MACHINES)
def test_forces_of_drawn_reactions_are_those_of_the_multipliers(name: str, scene: str) -> None:
    """The reaction at its point, as a wrench on the second body, against -Φ_qᵀ λ of the joint."""
    result = result_of(name, scene)
    drawn, table = moving_picture(result), result.description
    p = np.array([result.parameters[row.name] for row in table.parameters])
    constants = np.zeros(len(table.constants))
    full = np.concatenate([p, constants])
    result._mechanism.kernels.constants(full)
    equations = Equations(result._mechanism, full)
    bodies = [body.name for body in drawn.bodies]
    checked = 0
    for symbol, shape in drawn.having(Reaction):
        if shape.on == 0 or symbol.role == "force":
            continue
        rows = [k for k, row in enumerate(table.constraints) if row.element == symbol.element]
        own = [f"{bodies[shape.on]}.{letter}" for letter in ("x", "y", "phi")]
        columns = [table.coordinates.names.index(name) for name in own]
        for k in range(len(result.t)):
            x, y, ux, uy = (
                np.broadcast_to(values, len(result.t))[k]
                for values in (shape.x, shape.y, shape.ux, shape.uy)
            )
            fx, fy, torque = (
                result.reaction(symbol.element, word)[k] for word in ("fx", "fy", "torque")
            )
            force = fx * np.array([ux, uy]) + fy * np.array([-uy, ux])
            arm = np.array([x, y]) - drawn.poses[k, shape.on, :2]
            moment = arm[0] * force[1] - arm[1] * force[0] + torque
            slopes = equations.jacobian(result.t[k], result.samples.q[k])[np.ix_(rows, columns)]
            expected = -slopes.T @ result.samples.lam[k, rows]
            scale = 1.0 + np.abs(expected).max()
            assert_allclose([*force, moment], expected, atol=1e-9 * scale)
            checked += 1
    assert checked >= 6


@pytest.mark.parametrize(("name", "scene"), MACHINES)
def test_pins_hold_together_at_all_instants(name: str, scene: str) -> None:
    drawn = moving_picture(result_of(name, scene))
    pins = drawn.having(Pin)
    assert pins
    for _, pin in pins:
        assert_allclose(drawn.at(pin.i), drawn.at(pin.j), atol=1e-7)


def _same(one: Picture, other: Picture) -> None:
    assert [b.name for b in one.bodies] == [b.name for b in other.bodies]
    assert [(s.element, type(s.shape)) for s in one.symbols] == [
        (s.element, type(s.shape)) for s in other.symbols
    ]


def test_the_picture_before_the_build_is_that_of_the_built_machine() -> None:
    before = declared_picture(read_model("slider_crank").model, "kinematics", {"rod_length": 3.2})
    machine = load("slider_crank", "kinematics")
    after = moving_picture(
        machine.kinematics([0.0], parameters={"rod_length": 3.2}, progress=False)
    )
    _same(before, after)
    assert_allclose(after.poses[0], before.poses, atol=1e-8)
    for one, other in zip(before.symbols, after.symbols, strict=True):
        if isinstance(one.shape, Pin) and isinstance(other.shape, Pin):
            assert_allclose([*one.shape.i, *one.shape.j], [*other.shape.i, *other.shape.j])


def test_a_picture_module_of_another_version_is_built_anew(tmp_path: Path) -> None:
    model = Model("turned")
    crank = model.body("crank")
    model.revolute("hinge", model.ground.at(0, 0), crank.at(-1, 0))
    model.driver("motor", crank.phi, t)
    model.scene("turning", drivers=["motor"], analysis="kinematics")
    result = load(model, folder=tmp_path).kinematics(1.0)
    (first, *_) = moving_picture(result).symbols
    (place,) = tmp_path.rglob("*__picture.py")
    text = place.read_text()
    unsigned = re.sub(f"{MARK}.*", MARK + UNSIGNED, text.replace("('i', ", "('old', "))
    place.write_text(signed(unsigned))
    assert moving_picture(result).symbols[0] == first
    assert place.read_text() == text


def test_applied_forces_follow_the_motion() -> None:
    result = load("slider_crank", "compressor").simulate(0.3, 40, progress=False)
    drawn = moving_picture(result)
    (gas_force,) = (s.shape for s in drawn.symbols if s.element == "gas")
    x, vx = result.q("slider.x"), result.v("slider.vx")
    compression = -282857 / (6 - x) + 62857
    gas = np.where((vx > 0) & (x >= 1.5) & (x <= 5), compression, 0.0)
    here = (x < 4.99) | (vx < 0)
    assert here.sum() > 20
    assert_allclose(gas_force.fx[here], gas[here], rtol=1e-12)


def test_joints_that_are_released_act_until_then() -> None:
    result = load("trebuchet", "throw").simulate(1.5, 300, progress=False)
    drawn = moving_picture(result)
    (change,) = result.reconnections
    ((rod, _),) = drawn.having(Rod)
    ((first, last),) = rod.spans
    assert first == 0.0
    step = max(b - a for a, b in pairwise(result.t))
    assert change.time <= last <= change.time + step
    assert not any(symbol.spans for symbol, _ in drawn.having(Pin))


def test_a_part_of_a_run_has_the_outlines_and_the_motion_of_the_whole() -> None:
    result = load("trebuchet", "throw").simulate(3.0, 151, progress=False)
    whole, late = moving_picture(result), moving_picture(result, result.at([2.5, 2.6]))
    for one, other in zip(late.bodies, whole.bodies, strict=True):
        assert all(map(np.array_equal, one.outlines, other.outlines))
    assert late.size == whole.size
    assert {s.element for s in whole.symbols} - {s.element for s in late.symbols} == {"sling"}
    assert late.poses.shape == (2, *whole.poses.shape[1:])
    assert np.array_equal(late.motion, whole.poses)
    assert np.array_equal(whole.motion, whole.poses)


def test_an_equilibrium_is_one_picture() -> None:
    rest = load("slider_crank", "gravity_equilibrium").equilibrium(progress=False)
    drawn = moving_picture(rest)
    assert drawn.poses.shape == (1, 4, 3)
    assert all(not np.ndim(p.point) for s in drawn.symbols for p in places(s.shape))
