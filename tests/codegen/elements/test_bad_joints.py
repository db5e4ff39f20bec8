"""What can be wrong with the library's joints and drivers is said by name, all of it at once."""

from pathlib import Path

import pytest

from codegen import Model
from tests.codegen.complaints import check, complaints

PINNED = """
model.revolute('A', model.ground.at(0, 0), a)
model.revolute('B', model.ground.at(0.3, 0.4), b)
"""
COAXIAL = """
c = model.body('c', mass=1, inertia=1)
model.revolute('A', model.ground.at(0, 1), a)
model.revolute('C', model.ground.at(0, 1), c)
model.revolute('B', c.at(0.3, 0.4), b)
"""
CARRIED = """
c = model.body('c', mass=1, inertia=1)
model.revolute('A', c.at(0, 0), a.at(0, 0.1))
model.revolute('B', b, c.at(2, 0))
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("model.relative('A', a, b, 'z', 1.0)", ["relative 'A': 'z' is none of 'x', 'y', 'phi'"]),
        ("model.relative('A', a, a.at(1, 0), 'x', 1)", ["relative 'A' connects body 'a' with its"]),
        (
            "model.relative('A', a, b, 'x', units().Quantity(1, 's'))",
            ["value of 'A': 1 second has the dimension .time., but m is needed"],
        ),
        (
            "model.distance('A', a, b, 0)",
            ["distance 'A': the length is 0 m; give a positive number, or use"],
        ),
        (
            "model.distance('A', a, b, 'q')",
            ["distance of 'A': 'q' is neither a number nor an expression"],
        ),
        (
            "model.distance('A', a, model.particle('p', 1.0).at('q', 0), 2)",
            ["point of 'A' on body 'p': 'q' is neither a number nor an expression"],
        ),
        (
            "model.cam_flat_follower('A', a.circle(0.1), b, axis=(0, 0))",
            ["cam and flat-faced follower 'A': the axis .0, 0. has no direction"],
        ),
        ("model.distance('A', a, b, -1.5)", [r"distance 'A': the length is -1\.5 m; give a posi"]),
        ("model.distance('A', a, b, float('nan'))", ["distance of 'A': the value is nan; give"]),
        (
            "model.revolute_translational('A', a, b, axis=(0, 0))",
            ["revolute-translational 'A': the axis .0, 0. has no direction"],
        ),
        (
            "model.revolute_translational('A', a, b, axis=7)",
            [r"axis of 'A': 7 is no pair; write axis=\(1, 0\)"],
        ),
        (
            "model.revolute_translational('A', a, b, distance=a.x)",
            ["revolute-translational 'A': a_x depends on a_x, but points"],
        ),
        ("model.weld('A', a, b, angle=a.phi)", ["weld 'A': a_phi depends on a_phi, but points"]),
        (
            "model.rack_and_pinion('A', a, b, 0, axis=(0, 0))",
            [
                "rack-and-pinion 'A': the axis",
                "rack-and-pinion 'A': the radius is 0 m; give a positive",
            ],
        ),
        ("model.gear('A', a, b, 0, 1)", [r"gear 'A': the radii \(0, 1\) m contain a 0"]),
        ("model.gear('A', a, b, -1, -2)", [r"gear 'A': the radii \(-1, -2\) m are those of two"]),
        ("model.gear('A', a, b, k, -k)", [r"gear 'A': the radii \(k, -k\) m add up to 0"]),
        (
            PINNED + "model.gear('G', a, b, 0.2, 0.31)",
            [r"gear 'G': the bearings on 'ground' hold the centres 0\.5 m apart.* mesh at 0\.51 m"],
        ),
        (
            PINNED + "model.gear('G', a, model.ground.at(0, 1), 0.2, 0.31)",
            [r"gear 'G': the bearings on 'ground' hold the centres 1 m apart"],
        ),
        (
            COAXIAL
            + "model.gear('S', a, b, 0.4, 0.2)\n"
            + "model.gear('R', b, model.ground.at(0, 1), 0.1, 0.6)",
            [
                r"gear 'S': the bearings on 'c' hold the centres 0\.5 m apart.* mesh at 0\.6 m",
                r"gear 'R': the bearings on 'c' hold the centres 0\.5 m apart.* mesh at 0\.7 m",
            ],
        ),
        (
            CARRIED + "model.gear('G', a.at(0, 0.1), b, 1, -4)",
            ["gear 'G': the bearings on 'c' hold the centres 2 m apart.* mesh at 3 m"],
        ),
    ],
)
def test_bad_joints(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, text), expected)


@pytest.mark.parametrize(
    "radii", ["(0.2, 0.3)", "(0.1 + 0.1, 0.29999999)", "(k, 0.5 - k)", "(-0.7, 0.2)"]
)
def test_gears_that_fit_their_bearings(radii: str) -> None:
    names: dict[str, object] = {}
    model = Model("fits")
    a, b = (model.body(n, mass=1.0, inertia=1.0) for n in "ab")
    names |= {"model": model, "a": a, "b": b, "k": model.parameter("k", 0.2, unit="m")}
    exec(PINNED, names)
    gear = model.gear("G", a, b, *eval(radii, names))
    assert gear.problems() == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "model.point_driver('D', model.ground.at(1, 1), 'x', t)",
            ["point driver 'D' moves a point of the ground; give one of a moving body"],
        ),
        ("model.point_driver('D', a, 'z', t)", ["driver 'D': 'z' is none of 'x', 'y', 'phi'"]),
        (
            "model.point_driver('D', a, 'x', b.x)",
            ["point driver 'D': the law b_x contains the coordinate b_x; a motion law depends on"],
        ),
        (
            "model.rotation_driver('D', a, b, a.omega * t)",
            ["relative driver 'D': .* contains the velocity a_omega"],
        ),
        (
            "model.relative_driver('D', a, a.at(1, 0), 'y', t)",
            ["relative driver 'D' connects body 'a' with itself"],
        ),
        (
            "model.translation_driver('D', a, b, t, axis=(0, 0))",
            ["translation driver 'D': the axis .0, 0. has no direction"],
        ),
        (
            "model.translation_driver('D', a, b, (1, 0), t)",
            [r"law of driver 'D': \(1, 0\) is neither a number", "axis of 'D': t is no pair"],
        ),
        (
            "model.distance_driver('D', a, b, sin(t))",
            [r"distance driver 'D': the law sin\(t\) is 0 m at t = 0; a distance stays positive"],
        ),
        ("model.distance_driver('D', a, b, -2)", ["distance driver 'D': the law -2 is -2 m at"]),
        ("model.distance_driver('D', a, b, Abs(a.x) + 1)", ["D': the law .* contains the coord"]),
        (
            "model.distance_driver('D', a, b, units().Quantity(3, 'kg'))",
            ["law of driver 'D': 3 kilogram has the dimension"],
        ),
        (
            "model.point_driver('D', a, 'x', t)\nmodel.rotation_driver('D', a, b, t)",
            ["driver 'D': the name is already that of a driver"],
        ),
    ],
)
def test_bad_drivers(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, text), expected)
