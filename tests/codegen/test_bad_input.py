"""What is wrong with a model is said by name, all of it at once, and nothing is written."""

import pickle
from pathlib import Path
from typing import Any

import pytest

from codegen import LinkwrightError
from tests.codegen.complaints import check, complaints


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # bodies, masses
        (
            "c = model.body('c')",
            ["scene 'default': body 'c' has no mass and no inertia; give it in"],
        ),
        ("c = model.body('c', mass=1)", ["scene 'default': body 'c' has no inertia; give it in"]),
        (
            "c = model.body('c', mass=-1, inertia=0)",
            ["mass of body 'c' is -1 kg; it must be positive", "inertia of body 'c' is 0 kg m"],
        ),
        (
            "c = model.body('c', mass=float('nan'), inertia=float('inf'))",
            ["mass of body 'c': the value is nan", "inertia of body 'c': the value is oo"],
        ),
        (
            "c = model.body('c', mass=I, inertia='heavy')",
            [
                "mass of body 'c': the value is I",
                "inertia of body 'c': 'heavy' is neither a number nor",
            ],
        ),
        (
            "c = model.body('c', mass=[1, 2], inertia=Matrix([1]))",
            ["mass of body 'c'.*neither", "inertia of body 'c'.*neither"],
        ),
        (
            "c = model.body('c', mass=Symbol('m'), inertia=a.x)",
            ["mass of body 'c': unknown symbol 'm'", "inertia of body 'c': unknown symbol 'a_x'"],
        ),
        (
            "c = model.body('c', mass=model.parameter('w', -2.0), inertia=1)",
            ["mass of body 'c' is -2 kg", "parameter 'w' is -2 , but must be positive"],
        ),
        # joints
        (
            "model.revolute('A', a.at(0, 0), a.at(1, 0))",
            ["revolute 'A' connects body 'a' with itself"],
        ),
        (
            "c = Model('other').body('c', 1, 1)\nmodel.revolute('A', a.at(0, 0), c.at(1, 0))",
            ["revolute 'A': body 'c' belongs to another model; use a body of 'm'"],
        ),
        ("model.revolute('A', a.at(0, 0), 7)", ["'A': 7 is neither a point nor a body"]),
        (
            "model.translational('A', a, b, axis=(0, 0))",
            ["translational 'A': the axis .0, 0. has no direction"],
        ),
        (
            "model.revolute_revolute('A', a.at(0, 0), b.at(0, 0), -2.0)",
            ["revolute-revolute 'A': the length is -2 m; give a positive number, or use a revo"],
        ),
        (
            "model.revolute('A', model.ground.at(sin(t), 0), a.at(0, 0))",
            [r"revolute 'A': sin\(t\) depends on t, but points, axes"],
        ),
        (
            "model.revolute_revolute('A', a.at(0, 0), b.at(0, 0), 1 + a.x**2)",
            ["revolute-revolute 'A': .* depends on a_x, but points"],
        ),
        ("model.absolute('A', a, 'z', 1.0)", ["absolute 'A': 'z' is none of 'x', 'y', 'phi'"]),
        (
            "model.absolute('A', a, 'x', Abs(a.y))",
            ["Abs.a_y. has a kink", "A': Abs.a_y. depends on a_y"],
        ),
        ("model.constraint('c', 3 * k)", ["constraint 'c': .* names no coordinate of a body"]),
        ("model.constraint('c', a.vx - 3)", ["constraint 'c': .* contains the velocity a_vx"]),
        ("model.constraint('c', Abs(a.x) - 1)", ["constraint 'c': Abs.a_x. has a kink"]),
        (
            "model.constraint('c', Piecewise((a.x, a.x > 0), (a.y, True)))",
            ["constraint 'c': the condition a_x > 0 stands where nothing may switch"],
        ),
        (
            "model.constraint('c', a.x - Symbol('wid'))",
            [r"constraint 'c': unknown symbol 'wid'; declare it with model.parameter\('wid'"],
        ),
        (
            "model.constraint('c', a.x - sin(Symbol('t')))",
            ["constraint 'c': the symbol 't' is not the time; use the t of 'from codegen"],
        ),
        (
            "model.constraint('c', a.x - Symbol('k'))",
            ["constraint 'c': the symbol 'k' has the name of a parameter but is another symbol"],
        ),
        (
            "model.constraint('c', a.x - gamma(a.y))",
            [r"constraint 'c': gamma\(a_y\) cannot be compiled"],
        ),
        (
            "model.constraint('c', a.x + I)",
            ["constraint 'c': .* contains I; give finite real numbers"],
        ),
        # drivers
        ("model.driver('d', a.omega, 3)", ["driver 'd': .* contains the velocity a_omega"]),
        ("model.driver('d', k, 3 * t)", ["driver 'd': k names no coordinate of a body"]),
        ("model.driver('d', a.x, b.x)", ["driver 'd': the law b_x contains the coordinate b_x"]),
        ("model.driver('d', a.x, Max(t, a.y))", ["driver 'd': the law .* contains the coordin"]),
        (
            "model.constraint('c', a.x - floor(a.y))",
            [r"constraint 'c': floor\(a_y\) jumps where coordinates say; only the time and par"],
        ),
        ("model.driver('d', a.x, '3 * t')", ["law of driver 'd': '3 . t' is neither a number nor"]),
        # effects
        (
            "model.force('f', on=model.ground.at(1, 0), fx=1)",
            ["force 'f' acts on the ground; give a moving"],
        ),
        ("model.torque('f', on=model.ground, value=1)", ["torque 'f' acts on the ground"]),
        (
            "model.force('f', on=a, fx=Symbol('kk'))",
            [r"force 'f': unknown symbol 'kk'; declare it with .*, or did you mean 'k'\?"],
        ),
        ("model.force('f', on=a, fx=Symbol('t'))", ["force 'f': the symbol 't' is not the time"]),
        (
            "model.force('f', on=a, fx=1, frame='bodyy')",
            ["force 'f', frame: 'bodyy' is none of 'ground', 'body'"],
        ),
        ("model.force('f', on=a, fx=a.x > 0)", ["force 'f': a_x > 0 is neither a number nor"]),
        ("model.force('f', on=a, fx=float('inf'))", ["force 'f': the value is oo; give finite"]),
        (
            "model.force('f', on=a, fx=1, when=Eq(a.x, 1))",
            [r"force 'f': the condition Eq\(a_x, 1\) is an equality"],
        ),
        (
            "model.force('f', on=a, fx=1, when=And(a.x > 0, Ne(a.y, 1)))",
            [r"force 'f': the condition Ne\(a_y, 1\) is an equality"],
        ),
        (
            "model.force('f', on=a, fx=1, when=3.0 > 2.0)",
            ["force 'f': when=True never changes; compare"],
        ),
        ("model.force('f', on=a, fx=1, when=2.0 > 3.0)", ["force 'f': when=False never changes"]),
        (
            "model.torque('f', on=a, value=1, when=Integer(2) > 3)",
            ["torque 'f': when=(False|false) never"],
        ),
        (
            "model.force('f', on=a, fx=1, when='a.x > 0')",
            ["force 'f': when='a.x > 0' is no condition"],
        ),
        ("model.force('f', on=a, fx=1, when=a.x)", ["force 'f': when=a_x is no condition"]),
        (
            "model.force('f', on=a, fx=Piecewise((1, a.x > 0)))",
            [r"force 'f': Piecewise.* says nothing where none of its conditions holds; end"],
        ),
        (
            "model.force('f', on=a, fx=Function('g')(a.x))",
            [r"force 'f': g\(a_x\) cannot be compiled"],
        ),
        (
            "model.force('f', on=a, fx=sympify('erf(1)') * gamma(a.x))",
            ["force 'f': gamma.* cannot be compiled"],
        ),
        ("model.potential('v', k * a.vx**2)", ["potential 'v': .* contains the velocity a_vx"]),
        (
            "model.generalized_force('q', {a.vx: 3})",
            ["force 'q': a_vx is no coordinate; write body.x"],
        ),
        ("model.generalized_force('q', {'a.x': 3})", ["force 'q': 'a.x' is no coordinate"]),
        # parameters, quantities
        ("model.parameter('c', float('nan'))", ["parameter 'c' is nan; give a finite number"]),
        ("model.parameter('c', 'five')", ["parameter 'c': 'five' is not a number"]),
        ("model.driver('d', a, t)", ["driver 'd': Body.* its coordinates are, a.x, a.y or a.phi"]),
        ("model.driver('d', a.x, '2*t')", ["law of driver 'd': '2.t' .* it without quotes"]),
        (
            "model.driver('d', a.x, lambda t: t)",
            ["law of driver 'd': .*, in place of the function"],
        ),
        ("model.force('f', on=a, fx=(1, 0))", [r"force 'f': \(1, 0\) .*; give one value"]),
        (
            "model.parameter('c', -1.0, unit='m', sign='positive')",
            ["parameter 'c' is -1 m, but must be positive"],
        ),
        (
            "model.parameter('c', -1.0, sign='nonnegative')",
            ["parameter 'c' is -1 , but must be nonnegative"],
        ),
        ("model.parameter('c', 1.0, sign='plus')", ["parameter 'c', sign: 'plus' is none of"]),
        (
            "model.parameter('c', 1.0, unit='bananas')",
            ["parameter 'c': the unit 'bananas' is not known"],
        ),
        (
            "u = units()\nmodel.parameter('c', 3 * u.kg, unit='m')",
            [r"parameter 'c': 3 kilogram has the dimension \[mass\], but m is needed"],
        ),
        (
            "u = units()\nmodel.body('c', mass=3 * u.m, inertia=1)",
            [r"mass of body 'c': 3 meter has the dimension \[length\], but kg is needed"],
        ),
        (
            "model.parameter('a_x', 1.0)",
            ["parameter 'a_x' has the name of a coordinate or velocity of body 'a'"],
        ),
        ("model.parameter('t', 1.0)", ["parameter 't' has the name of the time; rename it"]),
        # names
        ("model.body('a', mass=1, inertia=1)", ["body 'a': the name is already that of a body"]),
        ("model.parameter('a', 1.0)", ["parameter 'a': the name is already that of a body"]),
        (
            "model.torque('k', on=a, value=1)",
            ["effect 'k': the name is already that of a parameter"],
        ),
        ("model.scene('s')\nmodel.scene('s')", ["scene 's' is declared twice"]),
        ("model.body('x' * 50, mass=1, inertia=1)", ["has 50 characters; .* up to 32"]),
        ("model.scene('x' * 99)", ["scene name .* has 99 characters; names of files .* up to 80"]),
        (
            "model.dry_friction('rub', slip=a.vx, normal=1, coefficient=0.1, fidelity='')",
            ["fidelity: '' is none of 'sticking', 'regularised'"],
        ),
        (
            "model.body('two__parts', mass=1, inertia=1)",
            ["body name 'two__parts' has two underscores"],
        ),
        # scenes
        (
            "model.scene('s', effects=['gravitty'])",
            ["scene 's': no effect 'gravitty'; did you mean 'gravity'?"],
        ),
        ("model.scene('s', effects='gravitty')", ["scene 's': no effect 'gravitty'"]),
        (
            "model.driver('d', a.x, t)\nmodel.scene('s', effects=['d'])",
            ["scene 's': no effect 'd'; it is a driver; name it in drivers="],
        ),
        (
            "model.revolute('pin', a.at(0, 0), b.at(0, 0))\nmodel.scene('s', effects=['pin'])",
            ["scene 's': no effect 'pin'; it is a joint, which takes part unless without= names"],
        ),
        ("model.scene('s', drivers=['gravity'])", ["no driver 'gravity'; it is an effect; name"]),
        ("model.scene('s', start={'a.theta': 1})", ["'a.theta' is no .*; did you mean .*a.phi"]),
        (
            "model.scene('s', start={'a.omgea': 1})",
            [r"'a.omgea' is no coordinate or velocity; did you mean a.omega\?"],
        ),
        ("model.scene('s', drivers=['motor'])", ["scene 's': no driver 'motor'; there are none"]),
        ("model.scene('s', without=['aa'])", ["scene 's': no body or joint 'aa'; .*'a'"]),
        ("model.scene('s', without=['a', 'b'])", ["scene 's': no body takes part"]),
        (
            "model.scene('s', start={'a.z': 1.0})",
            ["scene 's': 'a.z' is no coordinate or velocity; did you mean"],
        ),
        ("model.scene('s', start={'a.x': 'left'})", ["scene 's', a.x: 'left' is not a number"]),
        (
            "model.scene('s', guess={'a.x': float('nan')})",
            ["scene 's', a.x: the value is nan; give a finite"],
        ),
        (
            "model.scene('s', parameters={'kk': 1.0})",
            ["scene 's': no parameter 'kk'; did you mean 'k'?"],
        ),
        (
            "model.scene('s', parameters={k: float('inf')})",
            ["scene 's': parameter 'k' is inf; give a finite"],
        ),
        (
            "model.scene('s', analysis='kinematic')",
            ["scene 's', analysis: 'kinematic' is none of 'dynamics', 'kinematics'"],
        ),
        (
            "model.force('f', on=b, fx=1)\nmodel.scene('s', ['f'], without=[b])",
            ["scene 's': effect 'f' needs body 'b', which takes no part; leave 'f' out"],
        ),
        (
            "model.force('f', on=a, fx=b.x)\nmodel.scene('s', ['f'], without=[b])",
            ["scene 's': effect 'f' needs body 'b', which takes no part"],
        ),
        (
            "model.driver('d', b.x - a.x, t)\nmodel.scene('s', [], ['d'], without=[b])",
            ["scene 's': driver 'd' needs body 'b'"],
        ),
        (
            "model.scene('s', start={b.x: 1.0}, without=[b])",
            ["scene 's': b.x has a start value, but its body"],
        ),
        # too many constraints
        (
            "model.absolute('A', a, 'phi', 0.5)\nmodel.driver('d', a.phi, 0.5 + t)",
            [r"redundant: d\.phi \(driver\). Remove or relax 'd'"],
        ),
    ],
)
def test_message(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, text), expected)


def test_all_problems_of_a_model_come_at_once(tmp_path: Path) -> None:
    text = """
c = model.body("c", mass=-1.0, inertia=2.0)
model.revolute("A", a.at(0, 0), a.at(1, 0))
model.force("f", on=model.ground, fx=Symbol("z"))
model.potential("v", Symbol("kk") * a.x)
model.parameter("p", float("nan"))
model.body("class", 1, 1)
model.scene("s", ["nothing"], start={"q.x": 1})
"""
    found = complaints(tmp_path, text)
    check(
        found,
        [
            "mass of body 'c'",
            "revolute 'A' connects",
            "force 'f' acts on the ground",
            "force 'f': unknown symbol 'z'",
            "potential 'v'",
            "parameter 'p' is nan",
            "body name 'class'",
            "scene 's': no effect",
            "scene 's': 'q.x'",
        ],
    )


def test_all_problems_of_all_scenes_come_at_once(tmp_path: Path) -> None:
    text = """
c = model.body("c")
model.scene("one", ["gravity"])
model.scene("two", [], without=[c], start={c.x: 1.0})
"""
    check(
        complaints(tmp_path, text),
        ["scene 'one': body 'c' has no mass", "scene 'two': c.x has a start"],
    )


@pytest.mark.parametrize("arguments", [(), ("a",), ("a", 1), (("a", "b"),)])
def test_base_of_all_errors_takes_what_an_exception_takes(arguments: tuple[Any, ...]) -> None:
    error = LinkwrightError(*arguments)
    assert pickle.loads(pickle.dumps(error)).args == error.args
    assert ("a" in str(error)) == bool(arguments)
