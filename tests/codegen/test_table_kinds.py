"""Kinds of tables, what they are beyond their ends, and the branches between jumps."""

import cmath
import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator, interp1d

from codegen import Model, t
from codegen.errors import TableWarning
from codegen.tables.branches import branches
from codegen.tables.piecewise_cubic import Beyond, Kind, fit
from tests.codegen.workbench import Interpreted, State, complex_step

pytestmark = pytest.mark.filterwarnings("ignore::codegen.errors.TableWarning")  # of random data

RANDOM = np.random.default_rng(8)
X = np.sort(RANDOM.uniform(-1, 2, 12))
Y = np.round(RANDOM.normal(size=12), 1)
Y[4:7] = Y[4]  # a flat
THEIRS: dict[str, Callable[..., Any]] = {
    "linear": interp1d,
    "pchip": PchipInterpolator,
    "akima": Akima1DInterpolator,
    "spline": CubicSpline,
    "natural": lambda x, y: CubicSpline(x, y, bc_type="natural"),
}
ROAD_X = (0.0, 1.0, 2.0, 2.5, 2.75, 3.0, 3.5, 5.0, 6.0, 7.0, 8.0, 9.0, 12.0)
ROAD_Y = (0.0, 0.0, 0.0, 0.045, 0.06, 0.045, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def ours(name: str, x: Any, y: Any, periodic: bool = False, beyond: Beyond = "stop") -> Any:
    kind: Any = "spline" if name == "natural" else name
    ends: Any = "natural" if name == "natural" else "not-a-knot"
    return fit("some", list(x), list(y), periodic, kind, ends, beyond)


@pytest.mark.parametrize("name", THEIRS)
@pytest.mark.parametrize("count", [3, 4, 5, 12])
def test_kinds_are_scipys(name: str, count: int) -> None:
    count = max(count, 4) if name == "spline" else count
    x, y = X[:count], Y[:count]
    inside = np.linspace(x[0], x[-1], 101)[1:-1]
    theirs, table = THEIRS[name](x, y), ours(name, x, y)
    for order in range({"linear": 1, "spline": 4}.get(name, 3)):
        expected = theirs(inside, order) if order else theirs(inside)
        got = [table(at, order) for at in inside]
        assert_allclose(got, expected, atol=1e-11 * (1 + abs(expected).max()))


@pytest.mark.parametrize("name", ["pchip", "akima", "spline"])
@pytest.mark.parametrize("count", [4, 5, 12])
def test_those_that_repeat_are_scipys_of_many_periods(name: str, count: int) -> None:
    first, y, period = X[:count], np.append(Y[: count - 1], Y[0]), X[count - 1] - X[0]
    x, heights = np.concatenate([first[:-1] + k * period for k in range(-2, 4)]), np.tile(y[:-1], 6)
    theirs = (
        CubicSpline(first, y, bc_type="periodic") if name == "spline" else THEIRS[name](x, heights)
    )
    table = ours(name, first, y, True)
    inside = np.linspace(X[0] - period, first[-1] + period, 200)[1:-1]
    for order in range(4 if name == "spline" else 3):
        expected = theirs(inside, order)
        got = [table(at, order) for at in inside]
        assert_allclose(got, expected, atol=1e-11 * (1 + abs(expected).max()))


def test_road_stays_flat_behind_its_bump() -> None:
    """By default; the spline was 70.7 mm high there with the six points of such a bump."""
    road = Model("road").table("road", ROAD_X, ROAD_Y)
    at = np.linspace(3.5, 12.0, 200)
    assert_allclose([road.table(x) for x in at], 0.0, atol=0)
    assert max(road.table(x) for x in np.linspace(0, 12, 500)) <= 0.06


def test_spline_that_leaves_its_data_says_where() -> None:
    model = Model("road")
    with pytest.warns(TableWarning) as told:
        model.table("road", ROAD_X, ROAD_Y, kind="spline")
    (warning,) = told
    text = str(warning.message)
    assert text.startswith("table 'road': the spline leaves the range of its data, 0 to 0.06, by ")
    assert "give kind='pchip'" in text
    assert warning.filename == __file__
    table = fit("road", ROAD_X, ROAD_Y, False)
    dense = np.linspace(0, 12, 20001)
    values = np.array([table(x) for x in dense])
    worst = dense[np.argmax(np.maximum(values - 0.06, -values))]
    value, at = (
        float(text.partition(word)[2].split()[0].strip(";")) for word in ("it is ", " at ")
    )
    assert_allclose((at, value), (worst, table(worst)), rtol=1e-3)


def test_spline_of_a_wave_says_nothing() -> None:
    x = np.linspace(0, 2 * np.pi, 13)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Model("wave").table("wave", x, np.sin(x) - 0.0 * x, kind="spline")


@pytest.mark.parametrize("name", THEIRS)
def test_beyond_the_ends(name: str) -> None:
    held, on, ended = (ours(name, X, Y, False, b) for b in ("hold", "extrapolate", "stop"))
    assert (held(X[0] - 1), held(X[-1] + 1)) == (Y[0], pytest.approx(Y[-1], rel=1e-13))
    assert (held(X[0] - 1, 1), held(X[-1] + 1, 2)) == (0.0, 0.0)
    assert math.isnan(ended(X[-1] + 0.1))
    if name != "linear":
        expected = THEIRS[name](X, Y)
        theirs = [float(expected(at, extrapolate=True)) for at in (X[0] - 0.2, X[-1] + 0.2)]
        assert_allclose([on(X[0] - 0.2), on(X[-1] + 0.2)], theirs, rtol=1e-9)


@pytest.mark.parametrize("kind", ["linear", "pchip", "akima", "spline"])
@pytest.mark.parametrize("beyond", ["hold", "extrapolate", "periodic"])
@pytest.mark.parametrize("count", [8, 11, 12])
def test_branches_are_the_table_by_turns(kind: Kind, beyond: Any, count: int) -> None:
    """Each on its own pieces, smooth past their ends, and a function of slope one says which."""
    periodic = beyond == "periodic"
    x, y = X[:count], Y[:count]
    y = np.append(y[:-1], y[0]) if periodic else y
    table = fit("t", x.tolist(), y.tolist(), periodic, kind, beyond="stop" if periodic else beyond)
    dealt = branches(table)
    assert dealt is not None
    even, odd, knots = dealt
    span = x[-1] - x[0]
    assert knots(x[0] - 7 * span) == pytest.approx(knots(x[0] - 5 * span)) or not periodic
    for at in np.linspace(x[0] - 0.4 * span, x[-1] + 0.4 * span, 400):
        here = even if knots(at) > 0 else odd
        for order in range(3):
            assert_allclose(here(at, order), table(at, order), rtol=1e-8, atol=1e-9)
    kinks = [at for at in x if abs(knots(at)) < 1e-9]
    assert len(kinks) >= 4
    for at in kinks:
        assert abs(abs(knots(at, 1)) - 1) < 1e-12
        step = 1e-4 * span
        below, above = (even, odd) if knots(at - 1e-9) > 0 else (odd, even)
        assert_allclose(below(at - step), table(at - step), atol=1e-12)
        third = below(at - 1e-9, 3)
        assert_allclose(below(at + step, 2), below(at - 1e-9, 2) + third * step, atol=1e-4)
        assert_allclose(above(at), table(at), atol=1e-12)


def test_straight_and_flat_pieces_are_one() -> None:
    straight = fit("t", [0, 1, 2, 3, 5], [0, 1, 2, 3, 0], False, "linear", beyond="extrapolate")
    (even, odd, knots) = branches(straight) or (None, None, None)
    assert (len(even.rows), len(odd.rows)) == (1, 1)
    assert [at for at in straight.knots if knots(at) == 0] == [3]
    assert branches(fit("t", [0, 1, 2], [5, 5, 5], False, "pchip")) is None


def forced(kind: Kind, beyond: Beyond, periodic: bool) -> tuple[Interpreted, Any]:
    model = Model("forced")
    body = model.body("body", mass=1.0, inertia=1.0)
    y = np.append(Y[:-1], Y[0]) if periodic else Y
    law = model.table("law", X, y, periodic, kind=kind, beyond=beyond)
    model.force("push", body, fx=law(body.x) * 2, fy=law(t))
    model.torque("turn", body, law(body.vy - 3 * body.phi))
    return Interpreted(model), law.table


@pytest.mark.parametrize("kind", ["linear", "pchip", "akima", "spline"])
@pytest.mark.parametrize(
    ("beyond", "periodic"),
    [("stop", False), ("hold", False), ("extrapolate", False), ("stop", True)],
)
def test_force_is_the_table_in_the_mode_of_its_place(
    kind: Kind, beyond: Beyond, periodic: bool
) -> None:
    machine, table = forced(kind, beyond, periodic)
    outside = () if beyond == "stop" and not periodic else (X[0] - 0.7, X[-1] + 0.3)
    for at in (*X, *np.linspace(X[0], X[-1], 40), *outside):
        state = State(t=float(at), q=np.array([at, 0.0, 0.2]), v=np.array([0.0, at + 0.6, 0.0]))
        g = machine.vector("switching", state)
        force = machine.vector("applied_forces", state, modes=(g > 0).astype(int))
        expected = table(at) * np.array([2.0, 1.0, 1.0])
        assert_allclose(force, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("form", ["pchip", "akima", "spline"])
def test_forces_of_a_potential_are_its_slopes(form: Kind) -> None:
    """By complex steps of the potential, in the modes of the place."""
    from codegen import Effect, element

    @element
    class Bump(Effect):
        """A potential by a table of two coordinates."""

        kind = "bump"
        name: str
        body: Any
        height: Any

        def potential(self, bodies: Any) -> sympy.Expr:
            return self.height(self.body.x + 0.3 * sympy.sin(self.body.y))

    model = Model("hill")
    body = model.body("body", mass=1.0, inertia=1.0)
    height = model.table("height", X, Y, kind=form, beyond="extrapolate")
    model.add(Bump("hill", body, height))
    machine = Interpreted(model)
    for at in np.linspace(X[0] + 0.3, X[-1] - 0.3, 25):
        state = State(t=0.0, q=np.array([at, 0.7, 0.0]), v=np.zeros(3))
        modes = (machine.vector("switching", state) > 0).astype(int)

        def energy(q: np.ndarray, modes: np.ndarray = modes) -> np.ndarray:
            here = State(t=0.0, q=q, v=np.zeros(3))
            return np.array([machine.vector("potential", here, cmath, modes=modes)])

        slope = machine.vector("potential_gradient", state, modes=modes)
        assert_allclose(slope, complex_step(energy, state.q)[0], rtol=1e-11, atol=1e-11)
