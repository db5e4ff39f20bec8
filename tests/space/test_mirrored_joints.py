"""Joints in space that close turned by half a turn are told of, and refused where they must not."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model, t
from codegen.errors import AssemblyError, ModelError
from runtime import Outcome, load
from tests.space.machines import X, Z
from tests.space.rotations import rotation

OVER = {"b.e0": 0.2, "b.e1": np.sqrt(1 - 0.2**2)}  # nearly half a turn about x
KINDS = ("weld", "translational", "revolute", "cylindrical", "planar")


def held(kind: str) -> Model:
    model = Model(f"held_by_{kind}", space=True)
    ground, body = model.ground, model.body("b", 1.0, (1, 1, 1))
    words = {} if kind == "weld" else {"axis": (ground.along(*Z), body.along(*Z))}
    getattr(model, kind)("W", ground.at(0, 0, 0), body.at(0, 0, 0), **words)
    model.scene("s")
    return model


@pytest.mark.parametrize("kind", KINDS)
def test_a_mirrored_closure_is_named(kind: str, workshop: Path) -> None:
    """By random guesses: what is not told is closed as it is drawn."""
    machine, random, told = load(held(kind), folder=workshop), np.random.default_rng(4), 0
    for _ in range(12):
        p = random.normal(size=4)
        guess = {f"b.e{k}": float(x) for k, x in enumerate(p / np.linalg.norm(p))}
        try:
            begin = machine.assemble(guess=guess)
        except AssemblyError as error:
            text = str(error)
            told += "joint 'W' closes with its bodies turned by half a turn" in text
            assert kind in KINDS[:2]
            continue
        A = rotation(begin.q[3:7])
        if kind in KINDS[:2]:
            assert np.abs(A - np.eye(3)).max() < 1e-9
        opposite = "The axes of the two bodies are opposite in W." in begin.note
        assert opposite == (A[2, 2] < 0.0)
        told += opposite
    assert 0 < told < 12


def test_a_weld_of_the_ground_and_one_turned_about_its_own_axis(workshop: Path) -> None:
    """Vectors of either body, the ground the second; f alone may be opposite."""
    model = Model("upside", space=True)
    body = model.body("b", 1.0, (1, 1, 1), at=(1, 0, 0), axes=(0, 0, 0.5))
    model.weld("W", body, model.ground, at=(0, 0, 0))
    model.scene("s")
    machine = load(model, folder=workshop)
    assert machine.assemble().note == ""
    spun = {"b.e0": np.cos(0.25 + 1.5), "b.e3": np.sin(0.25 + 1.5), "b.x": -1.0}
    with pytest.raises(AssemblyError, match="joint 'W' closes with its bodies turned by half"):
        machine.assemble(guess=spun)


@pytest.mark.parametrize("kind", KINDS[1:])
@pytest.mark.parametrize("along", [(0, 0, -1), (1, 0, -0.5), X])
def test_axes_that_are_opposite_at_the_drawing_are_refused(kind: str, along: Any) -> None:
    model = Model("drawn", space=True)
    body = model.body("b", 1.0, (1, 1, 1))
    axes = model.ground.along(*Z), body.along(*along)
    getattr(model, kind)("W", model.ground.at(0, 0, 0), body.at(0, 0, 0), axis=axes)
    angle = np.degrees(np.arccos(along[2] / np.linalg.norm(along)))
    text = rf"'W': axis: at the drawing those of 'ground' and 'b' are {angle:.4g}° apart.*axes="
    model.scene("s")
    with pytest.raises(ModelError, match=text):
        model.equations()


def test_the_rest_found_is_told_of(workshop: Path) -> None:
    model = held("revolute")
    model.force("push", model.bodies["b"].at(0.1, 0, 0), (1, 0, 0))
    model.scene("rest", ["push"])
    found = load(model, "rest", folder=workshop).equilibrium(guess=OVER, progress=False)
    assert found["b.Azz"] == pytest.approx(-1.0)
    assert "The axes of the two bodies are opposite in W." in found.message


def test_a_guess_is_told_how_far_closing_turns_a_body(workshop: Path) -> None:
    machine = load(held("revolute"), folder=workshop)
    half = np.radians(50.0)
    begin = machine.assemble(guess={"b.e0": np.cos(half), "b.e1": np.sin(half)})
    assert rotation(begin.q[3:7])[2, 2] == pytest.approx(-1.0)
    assert "turns by more" not in begin.note  # by 80°
    model = Model("far", space=True)
    body = model.body("b", 1.0, (1, 1, 1), at=(1, 0, 0))
    model.revolute("W", model.ground, body, at=(0, 0, 0), axis=Z)
    model.scene("s")
    far, there = load(model, folder=workshop), {"b.x": -0.8, "b.y": 0.6}
    assert far.assemble(start=there).note == ""  # no attitude is given
    said = far.assemble(start=there, guess={"b.e0": 1.0}).note
    assert said.startswith("Closing the joints turns by more than a right angle: b by 143.1°. If")


def test_a_weld_engages_as_it_is_drawn_or_ends_the_run(workshop: Path) -> None:
    """A body that spins about z is half a turn on at t = 1 s, and a whole one at t = 2 s."""
    for instant, ended in ((1.0, Outcome.INCONSISTENT), (2.0, Outcome.OK)):
        model = Model(f"spinning_{instant:.0f}", space=True)
        body = model.body("b", 1.0, (1, 1, 1))
        lock = model.weld("lock", model.ground, body, at=(0, 0, 0))
        model.engage(lock, when=t > instant)
        model.scene("s", start={"b.omega_x": 0.0, "b.omega_y": 0.0, "b.omega_z": np.pi})
        run = load(model, folder=workshop).simulate(2.5, 11, rtol=1e-11, progress=False)
        assert run.outcome is ended, run.message
        told = "where its bodies are turned by half a turn against the drawing" in run.message
        assert told == (instant == 1.0)


def test_a_hinge_that_engages_says_that_its_axes_are_opposite(workshop: Path) -> None:
    """A body that spins about x has turned its z axis over at t = 1 s, and back at t = 2 s."""
    for instant, opposite in ((1.0, True), (2.0, False)):
        model = Model(f"turned_over_{instant:.0f}", space=True)
        body = model.body("b", 1.0, (1, 1, 1))
        pin = model.revolute("pin", model.ground, body, at=(0, 0, 0), axis=Z)
        model.engage(pin, when=t > instant)
        model.scene("s", start={"b.omega_x": np.pi, "b.omega_y": 0.0, "b.omega_z": 0.0})
        run = load(model, folder=workshop).simulate(2.5, 11, rtol=1e-11, progress=False)
        assert run.outcome is Outcome.OK, run.message
        assert run.reconnections[0].opposite == opposite
        told = "Joint 'pin' engaged at t = 1 s, its axes opposite to the drawing, with the impulse"
        assert (told in run.message) == opposite


@pytest.mark.parametrize("kind", KINDS[1:])
def test_members_of_an_ensemble_are_told_as_single_runs(kind: str, workshop: Path) -> None:
    machine, turns = load(held(kind), folder=workshop), (0.0, 1.0, 1.0, 0.0)
    for e1 in (turns, turns[::-1], tuple(1.0 - x for x in turns)):
        starts = {"b.e0": 1.0 - np.array(e1), "b.e1": np.array(e1)}
        many = machine.ensemble(0.1, 3, starts=starts, progress=False)
        for k, turned in enumerate(e1):
            start = {"b.e0": 1.0 - turned, "b.e1": turned}
            try:
                text = machine.simulate(0.1, 3, start=start, progress=False).message
            except AssemblyError as error:
                text = str(error)
            assert many["message"].values[k] == text
            refused = bool(turned) and kind == "translational"
            assert (many["outcome"].values[k] == "AssemblyError") == refused
            assert np.isnan(many["q"].values[k]).all() == refused
            assert ("opposite" in text) == (bool(turned) and not refused)
