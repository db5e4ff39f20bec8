"""A potential whose pieces do not meet is refused; one with kinks alone is not."""

from collections.abc import Callable

import pytest
import sympy
from sympy import Abs, And, Heaviside, Max, Min, Piecewise, atan2, sign

from codegen import Model, ModelError, t
from codegen.check.potential_steps import find_step
from codegen.declare.body import Body
from codegen.derive.piecewise_conditions import as_pieces
from codegen.reading.scene_selection import valid_scenes

Expression = Callable[[sympy.Symbol, sympy.Symbol, sympy.Symbol, sympy.Symbol], sympy.Expr]

STEPS: dict[str, tuple[Expression, float | None]] = {
    "Heaviside": (lambda x, y, a, k: 5 * Heaviside(x), 5.0),
    "pieces": (lambda x, y, a, k: Piecewise((5, x > 0), (0, True)), 5.0),
    "negated": (lambda x, y, a, k: Piecewise((0, x <= 0), (5, True)), 5.0),
    "sign": (lambda x, y, a, k: y**2 + 2 * sign(x), 4.0),
    "away from its start": (lambda x, y, a, k: Piecewise((k * x**2, x > a), (0, True)), 9.0),
    "nearly met": (lambda x, y, a, k: Piecewise((k * (x - a) + 1e-3, x > a), (0, True)), 1e-3),
    "beside a slope": (lambda x, y, a, k: 1e6 * y + Piecewise((1, x > 0.5), (0, True)), 1.0),
    "corner": (lambda x, y, a, k: Piecewise((1, And(x > 0, y > 1)), (0, True)), 1.0),
    "far away": (lambda x, y, a, k: Heaviside(x - 2e5), 1.0),
    "round": (lambda x, y, a, k: Heaviside(x**2 + y**2 - 4), 1.0),
    "that moves": (lambda x, y, a, k: Piecewise((3, x > t), (0, True)), 3.0),
    "beside a kink": (lambda x, y, a, k: Max(x, 0) + sign(y), 2.0),
    "branch of an angle": (lambda x, y, a, k: atan2(y, x), 2 * sympy.pi.evalf()),
    "band": (lambda x, y, a, k: 5 * Heaviside(x - 0.3) * Heaviside(0.3001 - x), 5.0),
    "cell": (
        lambda x, y, a, k: Piecewise((5, And(x > 0.3, x < 0.3001, y > 0.7, y < 0.7001)), (0, True)),
        5.0,
    ),
    "cell of products": (
        lambda x, y, a, k: (
            k
            * Heaviside(x - a)
            * Heaviside(a + 1e-5 - x)
            * Heaviside(y - a)
            * Heaviside(1e-5 + a - y)
        ),
        100.0,
    ),
    "cell of signs": (
        lambda x, y, a, k: (
            (1 + sign(x - 2)) * (1 + sign(2.001 - x)) * (1 + sign(y - 1)) * (1 + sign(1.001 - y))
        ),
        16.0,
    ),
    "cell far away": (
        lambda x, y, a, k: Piecewise(
            (Piecewise((5, And(x > 40, x < 40.001)), (0, True)), And(y > -1e3, y < -999.99)),
            (0, True),
        ),
        5.0,
    ),
    "cell that is round": (
        lambda x, y, a, k: Piecewise(
            (5, And(x**2 + y**2 > 4, x**2 + y**2 < 4.001, y > 1.9999)), (0, True)
        ),
        5.0,
    ),
    "cell of angles": (
        lambda x, y, a, k: Piecewise(
            (3, And(sympy.sin(x) > 0.9999, y > 0.5, y < 0.5001)), (0, True)
        ),
        3.0,
    ),
    "in the middle of eight bands": (
        lambda x, y, a, k: Piecewise(
            *(((x - n) * (x - n - 1) + 5 * (n > 3), x < n + 1) for n in range(7)),
            ((x - 7) * (x - 8) + 5, True),
        ),
        5.0,
    ),
    "bump on an edge": (
        lambda x, y, a, k: 5 * sympy.exp(-(((y - 3) / 0.001) ** 2)) * Heaviside(x),
        None,
    ),
    "pole": (lambda x, y, a, k: Piecewise((1 / x, x > 0), (0, True)), None),
}
KINKS: dict[str, Expression] = {
    "band that nothing is in": lambda x, y, a, k: Piecewise((5, And(x > 0.3, x < 0.2)), (0, True)),
    "bump of a small cell": lambda x, y, a, k: Piecewise(
        (
            1e9 * ((x - 1) * (1.01 - x) * (y - 1) * (1.01 - y)) ** 2,
            And(x > 1, x < 1.01, y > 1, y < 1.01),
        ),
        (0, True),
    ),
    "many stops": lambda x, y, a, k: sum(k * Max(x - n, 0) ** 2 for n in range(6)),
    "Abs": lambda x, y, a, k: Abs(x),
    "power of Max": lambda x, y, a, k: Max(x, 0) ** 1.5,
    "stop": lambda x, y, a, k: k * Max(x - a, 0) ** 2 / 2,
    "softening": lambda x, y, a, k: Piecewise(
        (k * x**2 / 2, x < a), (k * a * x - k * a**2 / 2, True)
    ),
    "angle": lambda x, y, a, k: atan2(y, x) ** 2,
    "greatest of three": lambda x, y, a, k: Max(x, y, x * y),
    "steep": lambda x, y, a, k: Piecewise((1e9 * x, x > 0), (-1e9 * x, True)),
    "x sign x": lambda x, y, a, k: x * sign(x),
    "clipped": lambda x, y, a, k: Min(Abs(x), 1),
    "root": lambda x, y, a, k: sympy.sqrt(Abs(x)),
    "flat": lambda x, y, a, k: Piecewise((sympy.exp(-1 / x), x > 0), (0, True)),
    "x log x": lambda x, y, a, k: Piecewise((x * sympy.log(x), x > 0), (0, True)),
    "ring": lambda x, y, a, k: Piecewise(
        (k * (sympy.sqrt(x**2 + y**2) - 1) ** 2, x**2 + y**2 < 1), (0, True)
    ),
    "power of the depth in a ring": lambda x, y, a, k: Piecewise(
        ((x**2 + y**2 - 0.16) ** 2.5 / (sympy.sqrt(x**2 + y**2) + 0.4) ** 2.5, x**2 + y**2 > 0.16),
        (0, True),
    ),
    "sharp bend": lambda x, y, a, k: sympy.tanh(1e6 * x) * Heaviside(x),
    "switch in time": lambda x, y, a, k: Piecewise((x**2, t > 1), (2 * x**2, True)),
}


def disc() -> tuple[Model, Body, sympy.Symbol, sympy.Symbol]:
    model = Model("disc")
    body = model.body("disc", mass=1.0, inertia=1.0)
    return model, body, model.parameter("a", 0.3), model.parameter("k", 100.0)


@pytest.mark.parametrize("word", STEPS)
def test_a_step_is_refused_with_its_size(word: str) -> None:
    model, body, a, k = disc()
    expression, size = STEPS[word]
    model.potential("shelf", expression(body.x, body.y, a, k))
    with pytest.raises(ModelError) as error:
        valid_scenes(model, None)
    (problem,) = error.value.problems
    assert problem.startswith("scene 'default': the ")
    assert "of potential 'shelf' jumps by " in problem
    if size is not None:
        assert float(problem.split("jumps by ")[1].split()[0]) == pytest.approx(size, rel=1e-3)


@pytest.mark.parametrize("word", KINKS)
def test_kinks_are_welcome(word: str) -> None:
    model, body, a, k = disc()
    expression = KINKS[word](body.x, body.y, a, k)
    model.potential("shelf", expression)
    assert len(valid_scenes(model, None)) == 1
    numbers = {**model.defaults, body.x: 0.0, body.y: 0.0, body.phi: 0.0}
    assert find_step(as_pieces(expression), numbers) is None


def test_parameters_of_the_scene_decide() -> None:
    model, body, a, k = disc()
    b = model.parameter("b", 0.3)
    energy = Piecewise((k * (body.x - b) ** 2, body.x > a), (0, True))
    model.potential("stop", energy)
    model.scene("met", ["stop"])
    model.scene("apart", ["stop"], parameters={b: 0.2})
    assert len(valid_scenes(model, "met")) == 1
    with pytest.raises(ModelError, match=r"'apart': .*'stop' jumps by 1 J where disc_x > a"):
        valid_scenes(model, "apart")


def test_a_gap_with_a_step_is_refused() -> None:
    model, body, *_ = disc()
    model.contact("kerb", gap=body.y - 0.1 * Heaviside(body.x), stiffness=1e4)
    with pytest.raises(ModelError, match=r"gap of contact 'kerb' jumps by 0\.1 m"):
        valid_scenes(model, None)
