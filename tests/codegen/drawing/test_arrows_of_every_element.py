"""The arrows of every kind of element push its bodies as its equations do."""

import math
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.drawing.annotations import loads
from codegen.drawing.picture import Picture
from codegen.drawing.shapes import Drive
from codegen.elements.registry import kinds_of_elements
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.picture_kernels import lower_picture
from codegen.reference.pages import example_of
from tests.codegen.elements.test_every_element import fitting_state
from tests.codegen.workbench import Interpreted, State, plain

LIBRARY = {name: kind for name, kind in kinds_of_elements().items() if not kind.is_user_defined}
BARE = {
    "belt", "constraint", "elastic belt", "gear with backlash", "generalized force", "gravity",
    "potential", "screw",
}  # fmt: skip
"""Kinds whose forces have no arrow, as docs/how-to/pictures-and-movies.md says."""
PARTLY = {"clearance joint"}  # its friction has none


def picture(made: Interpreted, s: State) -> Picture:
    lowered = lower_picture(made.lowered)

    def values(kernel: str, time: float) -> np.ndarray:
        inputs = {"t": time, "q": plain(s.q), "v": plain(s.v), "p": plain(made.p)}
        out = evaluate(lowered.program, kernel, inputs, math)["out"]
        return np.array([out[k] for k in range(len(out))])

    curves = partial(values, "curves")
    return lowered.layout.picture(np.array([s.t]), values("picture", s.t)[None], curves).first


def exerted(made: Interpreted, s: State, lam: np.ndarray) -> dict[str, float]:
    """Reactions and quantities of effects by the names of their series."""
    kernels = {kernel.name for kernel in made.program.kernels}
    slots: dict[int, float] = {}
    for kernel in {"reactions", "switched_reactions"} & kernels:
        slots |= made.slots(kernel, s, lam=lam)
    rows = made.lowered.description.reactions
    return {f"{row[0]}.{row[1]}": slots.get(k, 0.0) for k, row in enumerate(rows)}


def pushed(drawn: Picture, series: dict[str, float]) -> tuple[dict[str, np.ndarray], set[str]]:
    """Force and moment about the origin of each body, by all arrows; elements that have one."""
    found: dict[str, np.ndarray] = {}
    poses = {body.name: pose for body, pose in zip(drawn.bodies, drawn.poses, strict=True)}
    acting = [load for load in loads(drawn, series) if load.size > 0]
    for load in acting:
        name, value = load.label.rpartition(" on ")[2], np.ravel(load.value)[0]
        parts = np.array([0.0, 0.0, value.real])
        if load.style != "torque":
            arm = np.ravel(load.at)[0] - complex(*poses[name][:2])
            parts = np.array([value.real, value.imag, (arm.conjugate() * value).imag])
        found[name] = found.get(name, 0.0) + parts
    return found, {load.element for load in acting}


@pytest.mark.parametrize("kind", [name for name in LIBRARY if name not in PARTLY])
def test_arrows_are_the_forces_on_the_bodies_that_they_name(kind: str) -> None:
    example = example_of(kind)
    model, name = example.model, example.element.name
    outputs = ["reactions", "forces", "torques"]
    model.scene("all", list(model.effects), list(model.drivers), outputs=outputs)
    made, drawn = Interpreted(model, "all"), set[str]()
    for seed in range(6):
        s = fitting_state(made, seed)
        if made.s:
            made.on_its_sides(s)
        if LIBRARY[kind].role == "force":  # also of forces that follow from multipliers
            a, lam = made.solution(s, modes=getattr(s, "modes", []))
            total = made.mass(s) @ a
        else:
            lam = np.random.default_rng(seed).uniform(-2, 2, made.m)
            total = made.vector("applied_forces", s) - made.jacobian(s).T @ lam
        found, acting = pushed(picture(made, s), exerted(made, s, lam))
        drawn |= acting
        for place, body in enumerate(model.bodies):
            # the reaction of a joint has no arrow on its first body, where others may have one
            shares = body == "i" and {*model.joints} - {name}
            if body in found and not shares:
                assert_allclose(found[body], total[3 * place : 3 * place + 3], atol=1e-9)
    assert (name in drawn) == (kind not in BARE)


@pytest.mark.parametrize("turned", [False, True])
def test_a_driven_angle_of_bodies_has_its_arrow_at_their_pin(turned: bool) -> None:
    model = Model("arm")
    arm = model.body("arm", mass=1.0, inertia=0.1)
    model.revolute("pin", model.ground.at(3, 2), arm.at(-0.5, 0))
    model.rotation_driver("motor", *([arm, model.ground][:: -1 if turned else 1]), 0 * t)
    model.scene("held", drivers=["motor"])
    drawn = picture(Interpreted(model), State(t=0.0, q=np.array([3.5, 2.0, 0.0]), v=np.zeros(3)))
    ((_, drive),) = drawn.having(Drive)
    assert drawn.at(drive.j) == pytest.approx(3 + 2j)
