"""Machines that are legal and unusual: what a compiler meets when its users get to work."""

import sympy
from sympy import And, Or, Piecewise

from codegen import Model, t


def free_body() -> Model:
    """No constraint at all, and no scene."""
    model = Model("free_body", gravity=(0, -9.81))
    ball = model.body("ball", mass=2.0, inertia=0.1)
    model.force("drag", on=ball, fx=-0.1 * ball.vx * abs(ball.vx))
    return model


def names_like_arguments() -> Model:
    """Parameters called as the arguments and modules of the kernels, bodies called i, j and p."""
    model = Model("names")
    names = [
        "q",
        "v",
        "p_7",
        "t2",
        "lam",
        "w_p_x",
        "values",
        "math",
        "numba",
        "max",
        "print",
        "f_1",
    ]
    numbers = [model.parameter(name, 1.0 + k / 10) for k, name in enumerate(names)]
    mass = model.parameter("OPTIONS", 2.0, unit="kg")
    i = model.body("i", mass=mass, inertia=numbers[0])
    j = model.body("j", mass=numbers[1] * numbers[2], inertia=1.5)
    p = model.body("p", mass=1.0, inertia=numbers[3] + 1)
    model.revolute("a", model.ground.at(0, 0), j.at(numbers[4], 0))
    model.revolute("math_1", i.at(0, numbers[5] / numbers[6]), j.at(-1, numbers[7]))
    model.translational("g", i, p.at(0.1, 0.2), axis=(numbers[8], 1), angle=numbers[9])
    model.torque("modes", on=p, value=numbers[10] * sympy.sin(p.phi) * numbers[11])
    model.force("p_8", on=i, fx=1.0, when=i.vx > 0)
    return model


def massless() -> Model:
    """Bodies without mass, moved by drivers alone; every pivot is a number."""
    model = Model("massless")
    shuttle = model.body("shuttle")
    model.constraint("diagonal", shuttle.x + shuttle.y)
    model.driver("drive", shuttle.x, sympy.sin(t))
    model.absolute("upright", shuttle, "phi", 0.0)
    model.scene("move", drivers=["drive"], analysis="kinematics")
    return model


def frozen() -> Model:
    """The same pendulum twice: with parameters, and with their numbers folded in."""
    model = Model("folded", gravity=(0, -9.81))
    length = model.parameter("length", 1.25, unit="m", sign="positive")
    mass = model.parameter("mass", 3.0, unit="kg")
    bob = model.body("bob", mass=mass, inertia=mass * length**2 / 3)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    model.scene("open", ["gravity"])
    model.scene("shut", ["gravity"], parameters={mass: 4.0}, frozen=True)
    model.scene("same", ["gravity"], parameters={mass: 4.0})
    return model


def long_expressions() -> Model:
    """Sums, products, conditions and choices that fill more than a line."""
    model = Model("long_winded")
    names = ("the_body_on_the_left_hand_side_0", "the_body_on_the_right_hand_side0")
    left, right = (model.body(name, mass=1.0, inertia=1.0) for name in names)
    states = [*left.coordinates, *right.coordinates, left.vx, left.omega, right.vy]
    terms = [sympy.sin((k + 1.5) * a) * b for k, a in enumerate(states) for b in states]
    model.force("sum", on=left, fx=sympy.Add(*terms))
    model.force("product", on=right, fy=sympy.Mul(*(2 + sympy.cos(s) for s in states)))
    many = [s > 0.25 * k for k, s in enumerate(states)]
    choice = Piecewise((sympy.exp(left.x), And(*many)), (left.y, Or(*many)), (3.5, True))
    model.force("choice", on=left, fy=choice)
    nested = sympy.S.Zero
    for k, s in enumerate(states):
        nested = Piecewise((s + nested / (k + 2), s > nested.subs(s, 1.0 * k)), (k - s, True))
        if k == 2:
            break
    model.torque("nested", on=right, value=nested)
    long_name = "parameter_with_quite_a_long_name"
    stiffness = model.parameter(long_name, 3.0, unit="N/m")
    model.potential("spring", stiffness**2 * (left.x - right.x) ** 2 / 2 + stiffness**3 * left.y)
    model.revolute("joint", left.at(stiffness, 1 / stiffness), right.at(0, 0))
    model.constraint("own", sympy.log(2 + left.x**2) - sympy.sqrt(2 + right.y**2) ** 3)
    return model


def functions() -> Model:
    """Every function that can be compiled."""
    model = Model("functions")
    body = model.body("body", mass=1.0, inertia=1.0)
    x, y, phi = body.coordinates
    half = sympy.tanh(x) / 2
    smooth = sympy.tan(half) + sympy.asin(half) * sympy.acos(half) + sympy.atan(y)
    smooth += sympy.atan2(x, y) + sympy.sinh(half) * sympy.cosh(half) - sympy.exp(-(phi**2))
    smooth += sympy.log(1 + x**2) + sympy.sqrt(1 + y**2) + (2 + x**2) ** (half / 3) + x**-3
    kinks = sympy.Max(x, y, 0.5) + sympy.Min(x, y) + abs(x) + sympy.sign(y) + sympy.Heaviside(phi)
    model.force("smooth", on=body, fx=smooth)
    shared = sympy.sin(3 * x) * sympy.exp(phi)
    both_sides = Piecewise((shared * y, body.vy > 0), (shared + 1, True))
    model.torque("both_sides", on=body, value=both_sides)
    model.force("kinks", on=body, fy=kinks, when=sympy.Not(And(x > y, abs(x) > 1)))
    return model


ODD = (free_body, names_like_arguments, massless, frozen, long_expressions, functions)
