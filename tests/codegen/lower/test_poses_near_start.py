"""Joints close before anything is compiled: long chains, and the branch near the guess."""

import numpy as np
import pytest

from codegen import Model
from codegen.derive.equations import derive
from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.lower.lowered_scene import lower
from codegen.lower.poses_near_start import Poses
from codegen.picture_at_start import declared_picture
from codegen.reading.scene_selection import valid_scenes


def chain(links: int, length: float = 0.1) -> Model:
    """Links that hang from the ground one on the other, without a guess."""
    model = Model("chain", gravity=(0, -9.81))
    end = model.ground.at(0, 0)
    for k in range(1, links + 1):
        link = model.body(f"link_{k}", mass=0.1, inertia=1e-4)
        model.revolute(f"J_{k}", end, link.at(-length / 2, 0))
        end = link.at(length / 2, 0)
    model.scene("hanging", ["gravity"])
    return model


def four_bar(elbow: float) -> Model:
    """A four-bar whose coupler is guessed above or below the crank."""
    model = Model("four_bar")
    crank, coupler, lever = (model.body(name, 1.0, 1.0) for name in ("crank", "coupler", "lever"))
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(0.2, 0), coupler.at(0, 0))
    model.revolute("C", coupler.at(0.5, 0), lever.at(0.4, 0))
    model.revolute("D", model.ground.at(0.6, 0), lever.at(0, 0))
    model.driver("motor", crank.phi, 1.0)
    model.scene("driven", drivers=["motor"], guess={coupler.phi: elbow, lever.phi: 2 * elbow})
    return model


def poses_of(model: Model) -> Poses:
    scenes, *_ = valid_scenes(model, None)
    return Poses(lower(derive(model, scenes)))


@pytest.mark.parametrize("links", [5, 30, 60])
def test_a_chain_closes_from_no_guess(links: int) -> None:
    poses = poses_of(chain(links))
    closed = poses.start()
    assert closed is not None
    q = closed[0].reshape(links, 3)
    assert np.abs(poses.residual(closed[0])).max() < 1e-10
    np.testing.assert_allclose(q[:, 0], 0.1 * np.arange(links) + 0.05, atol=1e-7)
    np.testing.assert_allclose(q[:, 1:], 0.0, atol=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_a_chain_closes_from_wrong_guesses(seed: int) -> None:
    poses = poses_of(chain(30))
    poses.guess = np.random.default_rng(seed).standard_normal(90)
    assert poses.start() is not None


def test_no_joint_of_a_long_chain_is_drawn_open() -> None:
    picture = declared_picture(chain(30))
    assert "do not close" not in picture.title
    assert not [stroke for stroke in lines_between_bodies(picture) if stroke.style == "gap"]


@pytest.mark.parametrize("elbow", [0.7, -0.7])
def test_the_branch_near_the_guess_is_kept(elbow: float) -> None:
    poses = poses_of(four_bar(elbow))
    closed = poses.start()
    assert closed is not None
    coupler = {name: v for (name, *_), v in zip(
        poses.description.coordinates, closed[0], strict=True)}["coupler.phi"]  # fmt: skip
    reach = np.array([0.6, 0.0]) - 0.2 * np.array([np.cos(1.0), np.sin(1.0)])
    along = np.arctan2(*reach[::-1])
    distance = np.hypot(*reach)
    bend = np.arccos((0.5**2 + distance**2 - 0.4**2) / (2 * 0.5 * distance))
    assert coupler == pytest.approx(along + np.sign(elbow) * bend, abs=1e-9)
