"""Elements of a user's own in space as classes, and the equations of a scene as matrices."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import linkwright as lw
from codegen.errors import ModelError
from runtime import load
from tests.space.machines import DOWN

I, J = lw.SpaceFrame("i"), lw.SpaceFrame("j")  # noqa: E741 (the two bodies of a joint)


@lw.element
class PointInPlane(lw.Constraint):
    """n_iᵀ d = 0: a point of body j stays in a plane of body i."""

    kind = "own plane in space"
    name: str
    i: lw.SpacePoint
    j: lw.SpacePoint
    normal: tuple[float, float, float]

    def statement(self) -> lw.Statement:
        phi = I.vector("n").dot(J.point - I.point)
        bindings = I.bind(self.i, n=self.normal) | J.bind(self.j)
        return lw.Statement((phi,), ("normal",), lw.WrenchReaction(J), bindings)


@lw.element
class SpinDrag(lw.Effect):
    """F = -c v and n' = -c ω' on a body."""

    kind = "own drag in space"
    name: str
    body: lw.SpaceBody
    c: float

    def forces(self, bodies: Any) -> Any:
        body = self.body
        pushes = {q: -self.c * v for q, v in zip(body.coordinates[:3], body.velocity, strict=True)}
        return pushes | body.torque(tuple(-self.c * w for w in body.omega))


def on_a_plane() -> Any:
    model: Any = lw.Model("on_a_plane", space=True, gravity=DOWN)
    ball = model.body("ball", 1.0, (0.1, 0.2, 0.25), at=(0, 0, 0.5))
    model.add(PointInPlane("slope", model.ground.at(0, 0, 0), ball.at(0.1, 0, -0.5), (0.6, 0, 0.8)))
    model.add(SpinDrag("drag", ball, 0.3))
    model.scene(
        "slide", ["gravity", "drag"], start={"ball.vy": 1.0, "ball.omega_z": 3.0},
        guess={"ball.z": 0.4}, outputs=["energy", "work(drag)"],
    )  # fmt: skip
    return model


@pytest.fixture(scope="module")
def model() -> Any:
    return on_a_plane()


@pytest.fixture(scope="module")
def result(workshop: Path, model: Any) -> Any:
    return load(model, folder=workshop).simulate(1.0, 11, rtol=1e-10, progress=False)


def test_own_elements_hold_and_push(result: Any) -> None:
    place = np.column_stack([result.q(f"ball.{c}") for c in "xyz"])
    foot = place + result.rotation("ball") @ [0.1, 0, -0.5]
    assert_allclose(foot @ [0.6, 0, 0.8], 0.0, atol=1e-12)
    lost = result.work("drag") - (result.energy() - result.energy()[0])
    assert_allclose(lost, 0.0, atol=1e-8)


def test_a_wrench_of_a_scene_without_reactions(result: Any) -> None:
    wrench = result.wrench("slope", "ball", (0.1, 0, -0.5))
    pushed = np.column_stack([result.a(f"ball.{c}") + 0.3 * result.v(f"ball.{c}") for c in "xyz"])
    assert_allclose(wrench[:, :3], pushed - DOWN, rtol=0.0, atol=1e-11)
    assert_allclose(wrench[:, 3:], 0.0, atol=1e-11)
    assert_allclose(np.cross(wrench[:, :3], [0.6, 0, 0.8]), 0.0, atol=1e-11)


def test_equations_have_the_accelerations_of_the_kernels(model: Any, result: Any) -> None:
    found = model.equations()
    n, k = len(found.q), 5
    numbers = (*result.samples.q[k], *result.samples.v[k])
    place = dict(zip((*found.q, *found.v), numbers, strict=True))
    matrices = (found.M, found.Phi_q, found.Q, found.gamma)
    mass, slopes, force, gamma = (np.array(one.subs(place).evalf(), float) for one in matrices)
    zeros = np.zeros((len(gamma), len(gamma)))
    system = np.block([[mass, slopes.T], [slopes, zeros]])
    solved = np.linalg.solve(system, np.vstack([force, gamma]))[:, 0]
    assert_allclose(solved[:n], result.samples.a[k], rtol=0.0, atol=1e-11)
    joint = found.constraints.index(("slope", "normal"))
    pushed = -solved[n + joint] * np.array([0.6, 0, 0.8])
    assert_allclose(result.wrench("slope", "ball")[k, :3], pushed, rtol=0.0, atol=1e-11)
    text = found._repr_latex_()
    assert r"\mathtt{ball\_Azz}" in text
    assert "Entry" not in text


def flat(model: Any) -> Any:
    other = lw.Model("flat")
    return model.add(other.body("leaf", 1.0, 1.0))


def flat_frame(model: Any) -> Any:
    @lw.element
    class Flat(lw.Constraint):
        """Two points keep their x."""

        kind = "flat one"
        name: str
        i: lw.Point
        j: lw.Point

        def statement(self) -> lw.Statement:
            phi = (lw.J.point - lw.I.point)[0]
            return lw.Statement((phi,), ("x",), None, lw.I.bind(self.i) | lw.J.bind(self.j))

    return model.add(Flat("F", model.ground.at(0, 0, 0), model.bodies["ball"].at(0, 0, 0)))


@pytest.mark.parametrize(
    ("mistake", "text"),
    [
        (flat, "body 'leaf': the bodies of a model are all in the plane or in space."),
        (flat_frame, "bind a point in space in a SpaceFrame"),
    ],
)
def test_elements_of_the_plane_are_refused(mistake: Any, text: str, tmp_path: Path) -> None:
    model = on_a_plane()
    mistake(model)
    with pytest.raises(ModelError, match=text):
        lw.build(model, out=tmp_path, compile=False)


def test_elements_of_space_are_refused_in_the_plane(tmp_path: Path) -> None:
    model: Any = lw.Model("flat")
    body = model.body("body", 1.0, 1.0)
    model.add(PointInPlane("slope", model.ground.at(0, 0), body.at(0, 0), (0, 0, 1)))
    model.scene("s")
    with pytest.raises(ModelError, match="is no body of a machine in space"):
        lw.build(model, out=tmp_path, compile=False)


def test_a_torque_has_three_numbers() -> None:
    body = lw.Model("m", space=True).body("b", 1.0, (1, 1, 1))
    with pytest.raises(lw.ModelError, match=r"torque of body 'b': \(1, 2\) is not 3 values\."):
        body.torque((1, 2))
