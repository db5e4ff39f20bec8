"""Laws of motion, programs of moves and Fourier series against closed forms of the handbooks."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import InputError, ModelError, alpha, fourier_series, motion_program, t
from codegen.declare.symbols import Parameter, coordinate
from codegen.tables.motion_laws import SHAPES

u = np.linspace(0.0, 1.0, 8001)


def modified_sine(x: np.ndarray) -> np.ndarray:
    begin = pi * x - np.sin(4 * pi * x) / 4
    middle = 2 + pi * x - 9 / 4 * np.sin((4 * pi * x + pi) / 3)
    end = 4 + pi * x - np.sin(4 * pi * x) / 4
    return np.select([x < 1 / 8, x < 7 / 8], [begin, middle], end) / (4 + pi)


def modified_trapezoid(x: np.ndarray) -> np.ndarray:
    """By the coefficients of Norton, Cam Design and Manufacturing Handbook, eight digits."""

    def half(x: np.ndarray) -> np.ndarray:
        begin = 0.38898448 * x - 0.0309544 * np.sin(4 * pi * x)
        middle = 2.44406184 * x**2 - 0.22203097 * x + 0.00723407
        end = 1.6110154 * x - 0.0309544 * np.sin(4 * pi * x - pi) - 0.3055077
        return np.select([x < 1 / 8, x < 3 / 8], [begin, middle], end)

    return np.where(x <= 0.5, half(x), 1 - half(1 - x))


CLOSED: dict[str, tuple[Callable[[np.ndarray], np.ndarray], float]] = {
    # and rounding: that of the largest coefficient, or of eight digits
    "harmonic": (lambda x: (1 - np.cos(pi * x)) / 2, 3e-15),
    "cycloid": (lambda x: x - np.sin(2 * pi * x) / (2 * pi), 3e-15),
    "3-4-5": (lambda x: 10 * x**3 - 15 * x**4 + 6 * x**5, 1e-14),
    "4-5-6-7": (lambda x: 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7, 5e-14),
    "modified sine": (modified_sine, 3e-15),
    "modified trapezoid": (modified_trapezoid, 2e-7),
}
PEAKS = {  # of velocity, acceleration and jerk: closed forms, and the digits of Norton
    "harmonic": (pi / 2, pi**2 / 2, pi**3 / 2, "1.571", "4.935", "15.5"),
    "cycloid": (2.0, 2 * pi, 4 * pi**2, "2.000", "6.283", "39.5"),
    "3-4-5": (15 / 8, 10 / np.sqrt(3), 60.0, "1.875", "5.774", "60.0"),
    "4-5-6-7": (35 / 16, 84 / np.sqrt(125), 52.5, "2.188", "7.513", "52.5"),
    "modified sine": (
        *(4 * pi / (4 + pi), 4 * pi**2 / (4 + pi), 16 * pi**3 / (4 + pi), "1.760", "5.528", "69.5"),
    ),
    "modified trapezoid": (
        *(2.0, 8 * pi / (2 + pi), 32 * pi**2 / (2 + pi), "2.000", "4.888", "61.4"),
    ),
}


def test_every_law_has_a_closed_form_here() -> None:
    assert {*CLOSED} == {*SHAPES} == {*PEAKS}


@pytest.mark.parametrize("name", SHAPES)
def test_law_is_that_of_the_handbook(name: str) -> None:
    program = motion_program([(1.0, 1.0, name)], units=("s", "m"), periodic=False)
    closed, error = CLOSED[name]
    assert_allclose(program.values(u), closed(u), rtol=0.0, atol=error)
    inside = u[1:-1]
    peaks = [np.abs(program.values(inside, order)).max() for order in (1, 2, 3)]
    velocity, acceleration, jerk, *digits = PEAKS[name]
    # the largest acceleration of "4-5-6-7" lies between two samples
    assert_allclose(peaks[:2], [velocity, acceleration], rtol=2e-7)
    assert peaks[2] == pytest.approx(jerk, rel=2e-3)
    shown = (f"{velocity:.3f}", f"{acceleration:.3f}", f"{jerk:.1f}")
    assert shown == tuple(digits)


@pytest.mark.parametrize("name", SHAPES)
def test_pieces_meet_and_ends_rest(name: str) -> None:
    program = motion_program([(1.0, 1.0, name)], units=("s", "m"), periodic=False)
    meetings = np.array([0.0, 0.125, 0.375, 0.625, 0.875, 1.0])
    orders = range(2 if name == "harmonic" else 3)
    for order in orders:
        sides = [program.values(meetings + side * 1e-13, order) for side in (-1, 1)]
        assert_allclose(*sides, rtol=0.0, atol=2e-11)
    if name == "harmonic":
        assert program.values(1e-9, 2) == pytest.approx(pi**2 / 2)
    assert_allclose(program.values([-3.0, 2.0]), [0.0, 1.0], rtol=0.0, atol=1e-15)
    assert_allclose(program.values([-3.0, 0.0, 1.0, 2.0], 1), 0.0, atol=1e-14)


def test_program_over_an_angle() -> None:
    """Rise, dwell, fall and dwell of different laws, in degrees and mm, over a turn and more."""
    moves = [(90, 20, "cycloid"), ("1 rad", "2 cm"), (60, 5, "3-4-5"), (60, 5)]
    last = 360 - 210 - np.degrees(1.0)
    program = motion_program([*moves, (last, 0, "harmonic")], units=("deg", "mm"))
    assert program.length == pytest.approx(2 * pi, rel=1e-15)
    at = np.array([0.3, 2.0, 0.5 * pi + 1.0 + pi / 6, 2 * pi - np.radians(0.25 * last)])
    x = 0.3 / (pi / 2)
    due = [0.02 * (x - np.sin(2 * pi * x) / (2 * pi)), 0.02, 0.0125]
    due.append(0.005 * (1 - np.cos(pi / 4)) / 2)
    for turns in (0, 1, -3):
        assert_allclose(program.values(at + turns * 2 * pi), due, rtol=1e-12)
    assert program.values([[0.3], [2.0]]).shape == (2, 1)
    assert float(program(2.0)) == 0.02
    assert float(program("2 rad")) == 0.02


def test_program_of_a_multiple_of_an_angle() -> None:
    program = motion_program([(180, 1, "cycloid"), (180, 0, "cycloid")], units=("deg", "m"))
    lobes = sympy.lambdify(alpha, program(3 * alpha).expression, "numpy")
    assert_allclose(lobes(np.radians([60.0, 180.0, 300.0])), 1.0)
    assert_allclose(lobes(np.radians([0.0, 120.0, 240.0, 360.0])), 0.0, atol=1e-14)


def test_values_may_be_parameters() -> None:
    h = Parameter("h", real=True)
    moves = [(1.0, h, "modified sine"), (1.0, 0, "modified sine")]
    program = motion_program(moves, units=("s", "m"))
    assert program(t).free_symbols == {h, t}
    assert program.values(0.5, parameters={h: 3.0}) == pytest.approx(1.5)
    assert program.values(0.5, 1, {"h": 3.0}) == pytest.approx(3.0 * 4 * pi / (4 + pi))
    with pytest.raises(ModelError, match=r"motion program over 2 s depends on h; give parameters="):
        program.values(0.5)


@pytest.mark.parametrize(
    ("limits", "stretches", "length"),
    [
        ((0.5, 2.0, 40.0), 7, 0.3 / 0.5 + 0.5 / 2.0 + 2.0 / 40.0),
        ((0.5, 5.0, 40.0), 5, 0.3 / 0.5 + 2 * np.sqrt(0.5 / 40.0)),  # 5 m/s² are not reached
        ((9.0, 2.0, 40.0), 5, 0.05 + np.sqrt(0.05**2 + 4 * 0.3 / 2.0)),  # nor are 9 m/s
        ((9.0, 90.0, 40.0), 3, 4 * np.cbrt(0.3 / 80.0)),
    ],
)
def test_s_curve_keeps_its_limits(
    limits: tuple[float, ...], stretches: int, length: float
) -> None:  # fmt: skip
    moves = [(None, 0.3, "S-curve")]
    program = motion_program(moves, units=("s", "m"), limits=limits, periodic=False)
    assert program.length == pytest.approx(length, rel=1e-13)
    at = (np.arange(40_000) + 0.5) * length / 40_000
    speed, acceleration, jerk = (program.values(at, order) for order in (1, 2, 3))
    jumps = np.abs(np.diff(np.round(jerk, 6))) > 0
    assert jumps.sum() + 1 == stretches
    assert_allclose(np.abs(jerk).max(), limits[2], rtol=1e-12)
    assert_allclose(np.abs(jerk)[np.abs(jerk) > 1e-6], limits[2], rtol=1e-12)
    assert speed.max() <= limits[0] * (1 + 1e-12)
    assert np.abs(acceleration).max() <= limits[1] * (1 + 1e-12)
    assert speed.min() >= -1e-12
    assert_allclose(program.values([0.0, length, length + 1.0]), [0.0, 0.3, 0.3], atol=1e-14)
    assert_allclose(np.trapezoid(speed, at), 0.3, rtol=1e-6)


@pytest.mark.parametrize(
    ("law", "limits"),
    [
        ("S-curve", (0.01, 1.0, 100.0)),
        ("S-curve", (1e-4, 1.0, 100.0)),
        ("S-curve", (1e-5, 1.0, 100.0)),
        ("trapezoidal", (1e-4, 1.0)),
    ],
)
def test_slow_moves_end_as_they_begin(law: str, limits: tuple[float, ...]) -> None:
    """Ramps that are a millionth of the move keep their digits: s(T - x) = h - s(x)."""
    move = motion_program([(None, 1, law)], units=("s", "m"), limits=limits, periodic=False)
    ramp = 2 * limits[0] / limits[1] + limits[0] / (limits[2] if limits[2:] else 1.0)
    at = np.linspace(0.0, ramp, 101)
    assert_allclose(move.values(move.length - at), 1 - move.values(at), rtol=0, atol=1e-14)
    rounding = 1e-15 * move.length * limits[1]
    assert_allclose(move.values(move.length - at, 1), move.values(at, 1), rtol=0, atol=rounding)
    assert_allclose(move.values(move.length / 2, 1), limits[0], rtol=1e-13)


def test_trapezoidal_speed_profile() -> None:
    moves = [(None, 300, "trapezoidal"), (0.5, 300), (None, 290, "trapezoidal")]
    units = ("s", "mm")
    program = motion_program(moves, units=units, limits=("0.5 m/s", 2000), periodic=False)
    long, short = 0.3 / 0.5 + 0.5 / 2.0, 2 * np.sqrt(0.01 / 2.0)
    assert program.length == pytest.approx(long + 0.5 + short, rel=1e-13)
    at = np.array([0.1, 0.25, 0.4, long - 0.1, long + 0.2, program.length])
    assert_allclose(program.values(at), [0.01, 0.0625, 0.1375, 0.29, 0.3, 0.29], rtol=1e-12)
    assert_allclose(program.values(at[:4], 2), [2.0, 0.0, 0.0, -2.0], atol=1e-10)


def test_fourier_series() -> None:
    h = Parameter("h", real=True)
    phi = coordinate("cam", "phi")
    series = fourier_series(phi, 0.1, [h, 0, 0.3], [0.2])
    due = 0.1 + h * sympy.cos(phi) + 0.3 * sympy.cos(3 * phi) + 0.2 * sympy.sin(phi)
    assert sympy.simplify(series - due) == 0
    assert fourier_series(t, sines=[2], period=0.5) == 2 * sympy.sin(2 * sympy.pi * t / 0.5)


@pytest.mark.parametrize(
    "words", [{"mean": "1 N"}, {"cosines": 0.5}, {"sines": ["0.5 N"]}, {"period": 0}]
)
def test_wrong_fourier_series_are_refused(words: dict[str, object]) -> None:
    with pytest.raises(ModelError, match=r"mean, cosines, sines and period are .*; write 1\.0"):
        fourier_series(t, **words)


def test_values_take_plain_numbers() -> None:
    program = motion_program([(1, 1, "cycloid")], units=("s", "m"), periodic=False)
    with pytest.raises(ModelError, match=r"over 1 s: '90 deg': give plain numbers, in SI units"):
        program.values("90 deg")
    with pytest.raises(InputError, match=r"order is True; it must be a whole number from 0"):
        program.values(0.5, True)


U = {"units": ("deg", "mm")}
RISE, FALL = (100, 12, "cycloid"), (260, 0, "cycloid")


@pytest.mark.parametrize(
    ("moves", "more", "message"),
    [
        ([(100, 12, "sine"), FALL], U, r"moves\[0\], law: 'sine' is none of 'harmonic', 'cycloid'"),
        ([(100, 12), FALL], U, r"moves\[0\] goes to 12 without a law; name one, as 'cycloid'\."),
        ([RISE, (250, 0, "cycloid")], U, r"the moves take 350°, not 360°; change a dwell"),
        ([RISE, (260, 1, "cycloid")], U, r"it begins at 0 and ends at 1; return, or give periodi"),
        ([(-100, 12, "cycloid"), FALL], U, r"moves\[0\], length is -100; give a number that is mo"),
        ([(None, 12, "cycloid"), FALL], U, r"moves\[0\], length: None is not a number"),
        ([("3 kg", 12, "cycloid"), FALL], U, r"moves\[0\], length: 3 kilogram has the dimension"),
        ([RISE, (260, "x", "cycloid")], U, r"moves\[1\], value: 'x' is neither a number nor an"),
        ([(None, 12, "S-curve"), FALL], U, r"3 limits= that decide how long it takes, speed, acce"),
        ([(None, 1, "trapezoidal")], {"limits": (1e-9, 1e3), "periodic": False}, "takes 1e12 time"),
        ([(1, 12, "trapezoidal"), FALL], {**U, "limits": (1, 2)}, r"write \(None, value, 'trapez"),
        ([RISE, FALL], {**U, "limits": (1, -2)}, r"limits\[1\] is -2; give a number that is more"),
        ([RISE, FALL], {"units": ("foo", "m")}, r"units=\('foo', 'm'\), limits=\(\); write \[\(1"),
        ([(1, 2, 3, 4)], U, r"moves=\[\(1, 2, 3, 4\)\], units=\('deg', 'mm'\)"),
        ([], U, r"moves=\[\], units="),
    ],
)  # fmt: skip
def test_mistakes_are_named(moves: object, more: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=f"motion_program: .*{message}"):
        motion_program(moves, **more)


def test_program_is_called_with_what_it_runs_over() -> None:
    program = motion_program([(1, 1, "cycloid"), (1, 0, "cycloid")], units=("s", "m"))
    with pytest.raises(ModelError, match=r"is called with cam_phi, in rad; give it what is in s"):
        program(coordinate("cam", "phi"))
    with pytest.raises(ModelError, match=r"'a': give numbers or expressions in s"):
        program("a")
    assert str(program(t)).startswith("motion_")
