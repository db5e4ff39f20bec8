"""What is wrong with a belt, a screw, a disc or a gear with backlash is said by name."""

from pathlib import Path

import pytest

from codegen import Model
from tests.codegen.complaints import check, complaints

ARM = """
arm = model.body('arm', mass=1, inertia=1)
model.revolute('A', arm.at(0, 0), a.at(0, 0.1))
model.revolute('B', b, arm.at(2, 0))
"""
COAXIAL = """
arm = model.body('arm', mass=1, inertia=1)
model.revolute('S', model.ground.at(0, 0), a)
model.revolute('A', model.ground.at(0, 0), arm)
model.revolute('B', b, arm.at(2, 0))
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "model.belt('B', a, a, 0, -1)",
            [
                "belt 'B' is between body 'a' and itself; give two",
                "belt 'B': the radius of the first pulley is 0 m; give a positive number",
                "belt 'B': the radius of the second pulley is -1 m; give a positive number",
            ],
        ),
        (
            "model.belt('B', a, b, 1, 2, carrier=b)",
            ["belt 'B': the carrier 'b' is one of its wheels; give the body that carries"],
        ),
        (
            "model.belt('B', model.ground, b, 1, 2)",
            ["belt 'B': the ground is one of its wheels and, as no carrier is given, carries"],
        ),
        (
            ARM + "model.belt('D', a, b, 1, 2)",
            ["belt 'D' turns against 'ground', but the bearings of 'a' and 'b' are on 'arm'; give"],
        ),
        (
            COAXIAL + "model.gear_with_backlash('D', a, b, 1, 2, backlash=0.1, stiffness=9)",
            ["gear with backlash 'D' turns against 'ground', but the bearings .* are on 'arm'; gi"],
        ),
        (
            "model.belt('B', a, model.particle('p', 1.0), 1, 2)",
            ["belt 'B' needs the angle of 'p', which has none; use a body with an angle"],
        ),
        (
            "model.belt('B', a, b, 1, 2, crossed='no')",
            ["belt 'B': crossed='no': write True or False"],
        ),
        (
            "model.belt('B', a.at(0, 0), b, 1, 2)",
            ["belt 'B': Point of 'a' is no body; it couples bodies that turn"],
        ),
        (
            "model.elastic_belt('B', a, b, 1, 2, stiffness=0, damping=-1, pretension=-2)",
            [
                "elastic belt 'B': the stiffness is 0 N/m; give a positive number, or model.belt",
                "elastic belt 'B': the damping is -1 N s/m; give a number that is not negative",
                "elastic belt 'B': the pretension is -2 N; give a number that is not negative",
            ],
        ),
        (
            "model.gear_with_backlash('G', a, b, 0, 2, backlash=-1, stiffness=-3)",
            [
                "gear with backlash 'G': the radii .0, 2. m contain a 0; give the radii",
                "gear with backlash 'G': the backlash is -1 m; give a number that is not negative",
                "gear with backlash 'G': the stiffness is -3 N/m; give a positive number, or model",
            ],
        ),
        (
            "model.gear_with_backlash('G', a, b, -1, -2, backlash=0, stiffness=3)",
            ["gear with backlash 'G': both gears are internal; make one radius positive"],
        ),
        (
            "model.screw('S', a, a.at(1, 0), a, 0, axis=(0, 0))",
            [
                "screw 'S' connects body 'a' with itself|screw 'S' is between body 'a' and itself",
                "screw 'S': the spindle 'a' is the frame in which it turns; give two bodies",
                "screw 'S': the axis .0, 0. has no direction; give one",
                "screw 'S': the lead is 0 m, and the nut never moves; give the travel of one turn",
            ],
        ),
        (
            "model.screw('S', model.ground, a, model.particle('p', 1.0), 1)",
            ["screw 'S' needs the angle of 'p', which has none; use a body with an angle"],
        ),
        (
            "model.one_way_clutch('C', a, a, -1)",
            [
                "one-way clutch 'C' is between body 'a' and itself; give two",
                "one-way clutch 'C': the capacity is -1 N m; give a positive number",
            ],
        ),
        (
            "model.one_way_clutch('C', a.at(0, 0), model.particle('p', 1.0), 2)",
            ["one-way clutch 'C': Point of 'a' is no body; a clutch couples two bodies"],
        ),
        (
            "model.rolling_disc('R', a, b, -1, axis=(0, 0))",
            [
                "rolling disc 'R': the axis .0, 0. has no direction; give one",
                "rolling disc 'R': the radius is -1 m; give a positive number; for a disc on the",
            ],
        ),
    ],
)
def test_bad_transmissions(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, text), expected)


@pytest.mark.parametrize(("text", "carrier"), [(ARM, "arm"), (COAXIAL, "arm"), ("", "ground")])
def test_carriers_that_fit_their_bearings(text: str, carrier: str) -> None:
    model = Model("fits")
    a, b = (model.body(n, mass=1.0, inertia=1.0) for n in "ab")
    exec(text, {"model": model, "a": a, "b": b})
    bodies = {**model.bodies, "ground": model.ground}
    belt = model.belt("belt", a, b, 1, 2, carrier=bodies[carrier])
    assert belt.problems() == []
