"""What is wrong with a spring, a contact or a bushing is said by name."""

from pathlib import Path

import pytest

from tests.codegen.complaints import check, complaints


def test_conditions_are_reported_in_the_order_of_the_pieces(tmp_path: Path) -> None:
    text = """
from sympy import Piecewise
c, d = Symbol("c", boolean=True), Symbol("d", boolean=True)
model.force("f", a, Piecewise((1, c), (2, d), (3, True)))
"""
    found = [line for line in complaints(tmp_path, text) if "is no condition" in line]
    assert [line.split()[2] for line in found] == ["c", "d"]


def test_contact_of_a_body_with_itself_is_one_problem(tmp_path: Path) -> None:
    text = "model.contact('A', a, a.at(1, 0), stiffness=0)"
    assert len(complaints(tmp_path, text)) == 1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "model.spring('s', a.at(1, 0), a.at(1, 0), 3, 1)",
            ["spring 's': both ends, .1, 0. and .1, 0., are on body 'a' and coincide; connect two"],
        ),
        (
            "model.spring('s', model.ground.at(0, 0), model.ground.at(1, 0), 3, 1)",
            ["spring 's': both ends.* on body 'ground' and keep their distance; connect two"],
        ),
        ("model.spring('s', a, b)", ["spring 's' does nothing; give it a stiffness"]),
        ("model.spring('s', a, b, 3)", ["spring 's' has a stiffness but no free length; give"]),
        ("model.spring('s', a, b, preload=3)", ["spring 's' has a preload but no free length; gi"]),
        (
            "model.spring('s', a, b, 3, 1, preload=2 * units().Quantity(1, 'm'))",
            ["preload of spring 's': 2 meter has the dimension .length., but N is needed"],
        ),
        (
            "model.spring('s', a, b, -3, -1, -2)",
            ["the stiffness is -3 N/m", "the free length is -1 m", "the damping is -2 N s/m"],
        ),
        (
            "model.spring('s', a, b, 3 * units().kg, 1)",
            ["stiffness of spring 's': 3 kilogram has the dimension .mass., but N/m is needed"],
        ),
        (
            "model.spring('s', a, b, None, 1)",
            ["stiffness of spring 's' is missing; give it in"],
        ),
        (
            "model.spring('s', a, b, force=3 * k)",
            ["spring 's': force=3.k is no function; write"],
        ),
        (
            "model.spring('s', a, b, force=lambda length, rate: Symbol('c') * rate)",
            ["spring 's': unknown symbol 'c'; declare it with model.parameter"],
        ),
        (
            """
from sympy import gamma
model.torsion_spring('s', a, b, torque=lambda angle, rate: gamma(rate))
""",
            ["torsion spring 's': gamma.-a_omega . b_omega. cannot be compiled"],
        ),
        (
            "model.spring('s', a, b, force=lambda length, rate: 'strong')",
            ["force of spring 's': 'strong' is neither a number nor"],
        ),
        ("model.torsion_spring('s', a, a, 3)", ["torsion spring 's' is between body 'a' and itse"]),
        (
            "model.torsion_spring('s', a, b.at(0, 0), -3)",
            [
                "torsion spring 's': Point.* is no body; a torsion spring turns two",
            ],
        ),
        ("model.torsion_spring('s', a, b)", ["torsion spring 's' does nothing"]),
        ("model.contact('c', a, stiffness=3)", ["contact 'c' has no gap; give two points, or"]),
        (
            "model.contact('c', a, b, gap=a.x, stiffness=3)",
            ["contact 'c' has both gap= and points; give one of them"],
        ),
        (
            "model.contact('c', a.at(0, 0), a.at(1, 0), stiffness=3, free_length=2)",
            ["contact 'c' is between body 'a' and itself; give two"],
        ),
        (
            "model.contact('c', gap=k, stiffness=3)",
            ["contact 'c': the gap k depends on no coordinate and never changes"],
        ),
        (
            "model.contact('c', gap=a.vx, stiffness=3)",
            ["contact 'c': the gap a_vx depends on no coord", "contains the velocity a_vx"],
        ),
        (
            "model.contact('c', a, b, direction=(0, 0), stiffness=3)",
            ["contact 'c': the direction .0, 0. points nowhere"],
        ),
        (
            "model.contact('c', a, b, stiffness=-3, damping=0)",
            ["contact 'c': the stiffness is -3 N/m"],
        ),
        ("model.contact('c', a, b, stiffness=0)", ["stiffness and damping are both 0"]),
        ("model.torque('n', a, 3, from_=a)", ["torque 'n' is between body 'a' and itself; give"]),
        (
            "model.torque('n', a, 3, from_=b.at(0, 0))",
            ["torque 'n': Point of 'b' is no body; a torque turns"],
        ),
        (
            "model.torque('n', a, 3, from_=model.particle('p', 1.0))",
            ["torque 'n' turns 'p', which is a particle; use a body"],
        ),
        ("model.force('f', a, 3, from_=a)", ["force 'f' is between body 'a' and itself; give"]),
        ("model.force('f', a, 3, from_=7)", ["force 'f': 7 is no body; from_ is the body that ex"]),
        (
            "model.force('f', a, 3, from_=model.particle('p', 1.0))",
            ["force 'f' reacts on 'p', which is a particle and bears no moment; use a body, or"],
        ),
        (
            "model.force('f', model.ground, 3, from_=model.ground)",
            ["force 'f' acts on the ground; give a moving body"],
        ),
        ("model.line_force('f', a, b, 0)", ["line force 'f' is 0 throughout; give a force in N"]),
        (
            "model.line_force('f', a.at(1, 0), a, 3)",
            ["line force 'f': both ends, .1, 0. and .0, 0., are on body 'a' and keep their dist"],
        ),
        (
            "model.line_force('f', a, b, lambda length: 3)",
            ["value of line force 'f': the function fails with TypeError"],
        ),
        (
            "model.motor('m', a, a, stall_torque=0, no_load_speed=-2)",
            [
                "motor 'm' is between body 'a' and itself; give two",
                "motor 'm': the stall torque is 0 N m; give a positive number",
                "motor 'm': the no-load speed is -2 rad/s; give a positive number",
            ],
        ),
        (
            "model.motor('m', b.at(0, 0), stall_torque=1, no_load_speed=2)",
            ["motor 'm': Point of 'b' is no body; a motor turns a rotor"],
        ),
        (
            "model.stop('s', 'pin', 0, 1, stiffness=3)",
            ["stop 's': 'pin' is no joint with a coordinate; give a revolute, a translational or"],
        ),
        (
            "model.stop('s', model.weld('w', a, b), 0, 1, stiffness=3)",
            ["stop 's': 'w' is no joint with a coordinate; give a revolute, a translational or"],
        ),
        ("model.stop('s', a.x, stiffness=3)", ["stop 's' has no limit; give lower=, upper= or b"]),
        (
            "model.stop('s', a.vx, 0, restitution=0.5)",
            ["stop 's': a_vx depends on no coordinate", "contains the velocity a_vx; a stop limit"],
        ),
        (
            "model.stop('s', a.x, 1, 0, stiffness=-3, damping=-1)",
            [
                "stop 's': the upper limit 0 is not above the lower one, 1; exchange them",
                "stop 's': the stiffness is -3 N/m; give a positive number, or restitution=",
                "stop 's': the damping is -1 N s/m; give a number that is not negative",
            ],
        ),
        (
            "model.stop('s', a.x, 1, 0, restitution=0.5)",
            ["stop 's': the upper limit 0 is not above the lower one, 1; exchange them"],
        ),
        (
            "model.stop('s', a.phi, 0, stiffness=3, restitution=1)",
            ["stop 's' has both restitution= and stiffness= or damping=; give restitution= for"],
        ),
        ("model.stop('s', a.x, 0)", ["stop 's' has neither stiffness= nor restitution=; give"]),
        (
            "model.clearance_joint('p', a, a.at(1, 0), -1, 0, exponent=0.5, damping=-2)",
            [
                "clearance joint 'p' is between body 'a' and itself; give two",
                "clearance joint 'p': the clearance is -1 m; give a positive number",
                "clearance joint 'p': the stiffness is 0; give a positive number",
                "clearance joint 'p': the exponent is 0.5; give one of at least 1, 1.5 for Hertz",
                "clearance joint 'p': the damping is -2 s/m; give a number that is not negative",
            ],
        ),
        (
            "model.clearance_joint('p', a, model.particle('q', 1.0), 1, 3, coefficient=0.1)",
            [
                "clearance joint 'p' has a coefficient of friction but no creep speed; give both",
                "clearance joint 'p' rubs on 'q', which is a particle and cannot turn; use a body",
            ],
        ),
        ("model.bushing('r', a, b)", ["bushing 'r': stiffness and damping are all 0"]),
        ("model.bushing('r', a, b, 3)", ["stiffness of bushing 'r': 3 must be three"]),
        ("model.bushing('r', a, a, (1, 2, 3))", ["bushing 'r' is between body 'a' and itself"]),
        (
            "model.bushing('r', a, b, (1, 2, 3), (0, -1, 0))",
            ["bushing 'r': the damping along y is -1 N s/m"],
        ),
    ],
)
def test_what_is_wrong_is_said_by_name(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, text), expected)
