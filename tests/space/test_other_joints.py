"""Joints of points and planes, with massless couplers, screws, gears and racks."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.drawing.shapes import Rod
from codegen.drawing.solids import solids
from codegen.drawing.space_shapes import SpaceJoint
from codegen.drawing.space_strokes import gap_in_space
from codegen.driver import build
from codegen.errors import ModelError
from codegen.picture_at_start import declared_picture
from runtime import load
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_campaign import Comparison
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import OTHER, RandomSpatialMechanism
from tests.random_mechanisms.spatial_loops import LINKS, Drawing
from tests.space.machines import DOWN, X, Y, Z

SECONDS, GRAVITY = 0.3, 9.81


def hung(name: Any, letters: str, *more: parts.SpatialJoint) -> RandomSpatialMechanism:
    """Bodies on one that turns about an oblique axis, each in a joint of its own."""
    to = Drawing(np.random.default_rng(7))
    to.join("R", parts.GROUND, to.body((0.3, 0.1, 0.2)), (0.0, 0.0, 0.0))
    for letter in letters:
        at = to.near(to.place(0), 0.5)
        far = to.near(at, 0.5) if letter in LINKS else at
        to.join(letter, 0, to.body(to.near(far, 0.6)), at, None, far)
    joints, forces = (*to.joints, *more), (parts.Gravity("gravity"),)
    mechanism = parts.SpatialMechanism(tuple(to.bodies), joints, forces)
    dense = SpatialDense(mechanism)
    state = dense.random_velocity(2)
    freedoms, redundant = dense.freedoms(state)
    assert redundant == 0
    return RandomSpatialMechanism(
        name, OTHER, "free", (), mechanism, state, freedoms, 0, SECONDS
    )  # fmt: skip


TEETH = parts.Gear("mesh", "R1", "R3", -1.5), parts.Rack("teeth", "R3", "T4", 0.4)
MACHINES: dict[str, Any] = {
    "points": ("PILKA",),
    "couplers": ("BQYVX",),
    "meshing": ("HRT", *TEETH),
}


@pytest.mark.parametrize("name", MACHINES)
def test_motions_and_reactions_agree_with_newton_and_euler(name: str, workshop: Path) -> None:
    verdict = Comparison(hung(name, *MACHINES[name]), workshop).judge("dop853")
    assert verdict.complaints == ()
    assert verdict.motion < 1e-9
    assert verdict.statics < 1e-9


LEAD, RATIO, RADIUS = 0.3, -2.5, 0.2
PITCH = LEAD / (2 * np.pi)
TORQUE, MASS, ABOUT = 0.4, 2.0, 0.05


def transmissions() -> Any:
    """Two screws along z, one of them driven, two gears, and a rack that falls on its pinion."""
    model: Any = Model("transmissions", space=True, gravity=DOWN)
    ground, inertia = model.ground, (0.04, 0.04, ABOUT)
    nuts = [model.body(f"nut{k}", MASS, inertia, at=(2 * k, 0, 1)) for k in range(2)]
    free, fed = (
        model.screw(f"screw{k}", ground, nut, LEAD, at=(2 * k, 0, 1), axis=Z)
        for k, nut in enumerate(nuts)
    )
    model.rotation_driver("feed", fed, 3 * t**2)
    wheels = [model.body(f"wheel{k}", 1.0, inertia, at=(k, 3, 0)) for k in range(3)]
    a, b, c = (
        model.revolute(f"axle{k}", ground, wheel, at=(k, 3, 0), axis=Z)
        for k, wheel in enumerate(wheels)
    )
    model.gear("mesh", a, b, RATIO)
    model.generalized_force("motor", {a.angle: TORQUE})
    rack = model.body("rack", MASS, inertia, at=(2.2, 3, 0))
    guide = model.translational("guide", ground, rack, at=(2.2, 3, 0), axis=Z)
    model.rack_and_pinion("teeth", c, guide, f"{1e3 * RADIUS} mm")
    model.scene("run", ["gravity", "motor"], ["feed"], outputs=["default", free.slide, fed.slide])
    return model


def test_transmissions_through_turns_as_in_closed_form(workshop: Path) -> None:
    """A screw under gravity, J θ̈ + m p (g + p θ̈) = 0, another driven, gears and a rack."""
    result = load(transmissions(), folder=workshop).simulate(2.0, 21, rtol=1e-12, progress=False)
    half, whole = result.t**2 / 2, np.ones_like(result.t)

    def agree(found: Any, exact: Any) -> None:
        assert_allclose(found, exact, rtol=1e-9, atol=1e-9)

    turning = -MASS * PITCH * GRAVITY / (ABOUT + MASS * PITCH**2)
    agree(result.q("screw0.angle"), turning * half)
    agree(result.q("screw0.slide"), PITCH * turning * half)
    agree(result["nut0.z"], 1 + PITCH * turning * half)
    agree(result.reaction("screw0", "fz"), MASS * (GRAVITY + PITCH * turning) * whole)
    agree(result.reaction("screw0", "tz"), ABOUT * turning * whole)
    force = MASS * (GRAVITY + PITCH * 6)
    agree(result["nut1.z"], 1 + PITCH * 6 * half)
    agree(result.reaction("screw1", "fz"), force * whole)
    agree(result.reaction("screw1", "tz"), -PITCH * force * whole)
    agree(result.wrench("screw1", "nut1")[:, [2, 5]].T, np.outer([force, -PITCH * force], whole))
    agree(result.reaction("feed", "torque"), (ABOUT * 6 + PITCH * force) * whole)
    turning = TORQUE / (ABOUT * (1 + RATIO**2))
    agree(result.q("axle0.angle"), turning * half)
    agree(result.q("axle1.angle"), RATIO * turning * half)
    agree(result.reaction("mesh", "torque"), RATIO * ABOUT * turning * whole)
    falling = -GRAVITY * MASS / (MASS + ABOUT / RADIUS**2)
    agree(result["rack.z"], falling * half)
    agree(result.q("axle2.angle"), falling / RADIUS * half)
    agree(result.reaction("teeth", "force"), MASS * (falling + GRAVITY) * whole)
    assert abs(result.q("screw0.angle")[-1]) > 4 * np.pi


def joined() -> Any:
    model: Any = Model("joined", space=True)
    body, other = (model.body(n, 1.0, (1, 1, 1), at=(k, 0, 0)) for k, n in enumerate("ab"))
    model.spherical("ball", model.ground, body, at=(0, 0, 0))
    model.revolute("hinge", body, other, at=(0.5, 0, 0), axis=Z)
    return model


MISTAKES: dict[str, tuple[Callable[[Any, Any, Any], Any], str]] = {
    "gear of a ball": (
        lambda m, a, b: m.gear("G", m.joints["hinge"], m.joints["ball"], 2),
        "spherical 'ball' has no angle; joints that turn about an axis have an angle, joints that",
    ),
    "rack of a hinge": (
        lambda m, a, b: m.rack_and_pinion("G", m.joints["hinge"], m.joints["hinge"], 0.1),
        "revolute in space 'hinge' has no slide; joints that turn about an axis have an angle,",
    ),
    "radius of a rack as an angle": (
        lambda m, a, b: m.rack_and_pinion(
            "G", m.joints["hinge"], m.strut("S", a, b, at=X, axis=X), "5 deg"
        ),
        "radius of rack in space 'G': 5 degree has the dimension dimensionless, but m is needed",
    ),
    "two radii of a gear": (
        lambda m, a, b: m.gear("G", m.joints["hinge"], m.joints["hinge"], 0.2, 0.3),
        "model.gear 'G': too many positional arguments; it takes (name, i, j, ratio, *, offset=0)",
    ),
    "gear of wheels without a carrier": (
        lambda m, a, b: m.gear(
            "G", m.joints["hinge"],
            m.revolute("A", m.ground, m.body("c", 1.0, (1, 1, 1)), at=X, axis=X), 2,
        ),
        ("gear in space 'G': joints 'hinge' of a and b, 'A' of ground and c have no carrier in "
         "common, and the angle of a joint is that of its second body against its first; join "
         "both to the body that carries them. For a coupling without one write "
         "model.constraint(name, A.angle - n * hinge.angle)."),
    ),
    "gear of bodies": (
        lambda m, a, b: m.gear("G", a, b, 2),
        "'G': body 'a' is no joint of 'joined' with an angle; give what model.revolute(...)",
    ),
    "gear of a joint that is left out": (
        lambda m, a, b: (
            m.gear("G", m.joints["hinge"], m.revolute("A", m.ground, a, at=X, axis=X), 2),
            m.scene("s", without=["hinge"]),
        ),
        "scene 's': something asks for hinge.angle, but joint 'hinge' takes no part; take it in,",
    ),
    "screw without a lead": (
        lambda m, a, b: m.screw("S", m.ground, a, 0, at=X, axis=Z),
        "screw in space 'S': the lead is 0 m, and the nut never moves; give the travel of one",
    ),
    "sleeve with a parallel hinge": (
        lambda m, a, b: m.revolute_cylindrical("S", a, b, at=X, axis=Z, hinge=Z, angle=0),
        "revolute_cylindrical 'S': its axes are parallel; use a revolute or cylindrical joint.",
    ),
    "axis of a wrong body": (
        lambda m, a, b: m.point_on_line("S", a, b, at=X, axis=b.along(*Z)),
        "point on line 'S': axis: Axis(",
    ),
    "link without length": (
        lambda m, a, b: m.revolute_spherical("S", a.at(1, 0, 0), b, axis=Z),
        "revolute-spherical 'S': the length is 0 m; give a positive number",
    ),
    "opposite normals": (
        lambda m, a, b: m.planar("S", a, b, at=X, axis=(a.along(*Z), b.along(0, 0, -1))),
        "planar 'S': axis: at the drawing those of 'a' and 'b' are 180° apart",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_told(case: str, tmp_path: Path) -> None:
    mistake, text = MISTAKES[case]
    model = joined()

    def declare_and_build() -> None:
        mistake(model, *model.bodies.values())
        build(model, scene=[*model.scenes][-1:] or None, out=tmp_path, compile=False)

    with pytest.raises(ModelError) as refusal:
        declare_and_build()
    assert text in str(refusal.value)


@pytest.mark.parametrize("word", ["weld", "translational", "spherical"])
def test_a_carrier_may_consist_of_bodies_that_turn_together(word: str, tmp_path: Path) -> None:
    """The frame of the second wheel stands on a part that a weld or a guide holds to the ground."""
    model: Any = Model("frames", space=True)
    part, frame, a, b = (model.body(n, 1.0, (1, 1, 1)) for n in ("part", "frame", "a", "b"))
    axis = {"axis": X} if word == "translational" else {}
    getattr(model, word)("foot", model.ground, part, at=X, **axis)
    model.weld("flange", part, frame, at=X)
    pair = [
        model.revolute(f"R{to.name}", on, to, at=X, axis=Z)
        for on, to in ((model.ground, a), (frame, b))
    ]
    model.gear("G", *pair, ratio=-2)
    if word == "spherical":
        with pytest.raises(ModelError, match="have no carrier in common"):
            build(model, out=tmp_path, compile=False)
    else:
        build(model, out=tmp_path, compile=False)


def test_pictures_show_no_gap_where_a_joint_slides() -> None:
    """A point in a plane and on a line, away from the points of body i."""
    model: Any = Model("open", space=True)
    body, ground = model.body("a", 1.0, (1, 1, 1), at=(0.2, 0.3, 0)), model.ground
    model.point_in_plane("plane", ground.at(0, 0, 0), body.at(0, 0, 0), axis=Z)
    model.strut("line", ground.at(0.2, 0, 0), body.at(0, 0, 0), axis=Y)
    model.revolute_translational(
        "block", ground.at(0.2, -1, 0), body.at(0, 0, 0), axis=Y, hinge=Z
    )  # fmt: skip
    model.revolute_spherical("link", ground.at(0.2, 1, 0), body.at(0, 0, 0), axis=Z)
    model.parallel_axes("turned", ground, body, axis=Z)
    model.scene("s", analysis="kinematics")
    picture = declared_picture(model)
    of_joints = (s for s in picture.symbols if isinstance(s.shape, SpaceJoint | Rod))
    forms = {s.element: getattr(s.shape, "form", "rod") for s in of_joints}
    assert forms == {"plane": "plate", "line": "bead", "block": "rail", "link": "rod"}
    drawn = {s.form for s in solids(picture) if s.element in forms}
    assert drawn == {"cylinder", "box", "ball", "plate"}
    assert not any(gap_in_space(picture, symbol) for symbol in picture.symbols)
