"""Mass, inertia and centre of outlines, and points of a body in the axes of its drawing."""

import re
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import (
    Body,
    Model,
    ModelError,
    Outline,
    ParameterError,
    alpha,
    bar,
    disc,
    read_outline,
    rectangle,
)
from codegen.declare.area_properties import area_condition, area_properties
from codegen.picture_at_start import declared_picture
from codegen.reference import pages
from runtime import load
from tests.codegen.workbench import Interpreted, library_kinds

DENSITY, THICKNESS = 7850.0, 0.004
L, W = 0.3, 0.04


def numbers(outline: Outline) -> list[float]:
    assert not [*area_condition(outline).problems("", {})]
    size, (x, y), polar = area_properties(outline, {})
    return [float(e) for e in (size, x, y, polar)]


def half_disc(r: float) -> tuple[float, float, float]:
    """Area, distance of the centre from the diameter, polar moment about the centre."""
    area, away = pi * r**2 / 2, 4 * r / (3 * pi)
    return area, away, area * r**2 / 2 - area * away**2


def slotted_bar(length: float, width: float) -> tuple[float, float]:
    """Area and polar moment, by parallel axes: a rectangle and two halves of a disc."""
    area, away, polar = half_disc(width / 2)
    whole = length * width + 2 * area
    inertia = length * width * (length**2 + width**2) / 12
    return whole, inertia + 2 * (polar + area * (length / 2 + away) ** 2)


def test_closed_forms() -> None:
    assert_allclose(numbers(rectangle(2.0, 1.0, (3, -4))), [2, 3, -4, 2 * 5 / 12], rtol=1e-14)
    expected = [pi / 4, 1, 1, pi / 32]
    assert_allclose(numbers(disc(0.5, (1, 1))), expected, rtol=1e-14)
    area, polar = slotted_bar(L, W)
    turned = bar(L, W, (0.1, 0.2), 0.4)
    middle = [0.1 + L / 2 * cos(0.4), 0.2 + L / 2 * sin(0.4)]
    assert_allclose(numbers(turned), [area, *middle, polar], rtol=1e-13)


def test_a_plate_with_holes_by_parallel_axes() -> None:
    plate = rectangle(1.0, 0.6).with_holes(disc(0.1, (0.2, 0.1)), bar(0.2, 0.05, (-0.3, -0.1)))
    slot, slot_polar = slotted_bar(0.2, 0.05)
    parts = [(0.6, 0.0, 0.6 * 1.36 / 12), (-pi * 0.01, 0.2 + 0.1j, -pi * 1e-4 / 2)]
    parts.append((-slot, -0.2 - 0.1j, -slot_polar))
    area = sum(a for a, *_ in parts)
    center = sum(a * c for a, c, _ in parts) / area
    polar = sum(j + a * abs(c - center) ** 2 for a, c, j in parts)
    assert_allclose(numbers(plate), [area, center.real, center.imag, polar], rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_polygons_and_flat_arcs_by_quadrature(seed: int) -> None:
    """A star-shaped line of straight edges and arcs, cut into triangles about a point in it."""
    random = np.random.default_rng(seed)
    angles = np.sort(random.uniform(0, 2 * pi, 9)) + 0.05 * np.arange(9)
    corners = (
        5.0 + 3j + random.uniform(0.8, 1.2, 9) * np.exp(1j * angles * 2 * pi / angles[-1] * 0.95)
    )
    bulges = tuple(random.choice([0.0, 1e-7, -1e-3, 0.05, -0.05], 9))
    outline = Outline(tuple((float(z.real), float(z.imag)) for z in corners), bulges)
    points: list[complex] = []
    share = np.linspace(0, 1, 4001)[:-1]
    ends = outline.vertices[1:] + outline.vertices[:1]
    # an arc is a straight line by a map of Möbius
    for start, end, bulge in zip(outline.vertices, ends, bulges, strict=True):
        weight = np.exp(-2j * np.arctan(bulge)) * share
        points += [
            *((complex(*start) * (1 - share) + complex(*end) * weight) / (1 - share + weight))
        ]
    p = np.array(points) - (5 + 3j)
    q = np.roll(p, -1)
    cross = (p.conj() * q).imag / 2
    area, moment = cross.sum(), (cross * (p + q) / 3).sum()
    about = (cross * (abs(p) ** 2 + abs(q) ** 2 + abs(p + q) ** 2) / 12).sum()
    middle = moment / area + 5 + 3j
    expected = [area, middle.real, middle.imag, about - abs(moment) ** 2 / area]
    assert_allclose(numbers(outline), expected, rtol=1e-8)
    backwards = Outline(outline.vertices[::-1], tuple(-b for b in (*bulges[-2::-1], bulges[-1])))
    assert_allclose(numbers(backwards), numbers(outline), rtol=1e-12)


def test_parameters_remain() -> None:
    model = Model("bar")
    a, w = model.parameter("a", L, unit="m"), model.parameter("w", W, unit="m")
    link = model.body("link", outline=bar(a, w), thickness=THICKNESS, density=DENSITY)
    assert link.center == (a / 2, 0)
    area, polar = slotted_bar(0.5, 0.06)
    found = [float(e.subs({a: 0.5, w: 0.06})) for e in (link.mass, link.inertia)]
    assert_allclose(found, np.multiply([area, polar], DENSITY * THICKNESS), rtol=1e-13)
    triangle = model.body("triangle", 2.0, outline=[(0, 0), (a, 0), (0, w)])
    assert triangle.mass == 2.0
    assert sympy.simplify(triangle.center[0] - a / 3) == 0
    assert_allclose(float(triangle.inertia.subs({a: 3, w: 2})), 2 * 13 / 18, rtol=1e-14)
    assert not model.problems


@pytest.mark.parametrize("held", [True, False])
def test_a_run_with_a_hole_outside_of_its_outline_is_refused(held: bool, tmp_path: Path) -> None:
    model = Model("plate", gravity=(0, -9.81))
    a, h = model.parameter("a", L, unit="m"), model.parameter("h", 0.1, unit="m")
    plate = bar(a, W).with_holes(disc(0.01, (h, 0)))
    link = model.body("link", outline=plate, thickness=THICKNESS, density=DENSITY)
    if held:
        model.revolute("hinge", model.ground.at(0, 0), link.at(0, 0))
    model.scene("free", effects=["gravity"])
    model.scene("other", effects=["gravity"], parameters={"h": 0.5})
    machine = load(model, scene="free", folder=tmp_path)
    text = "body 'link': outline: hole 1 is not within it at (0.51, 0) m; give lines round"
    with pytest.raises(ParameterError, match=re.escape(text)):
        machine.simulate(0.1, parameters={"h": 0.5})
    with pytest.raises(ParameterError, match="crosses itself or bounds no area"):
        machine.simulate(0.1, parameters={"a": -0.01})
    with pytest.raises(ModelError, match=re.escape(text)):
        load(model, scene="other", folder=tmp_path)
    runs = machine.ensemble(0.01, parameters={"h": [0.1, 0.2, 0.5]})
    assert list(runs.outcome.values) == ["OK", "OK", "ParameterError"]


@pytest.mark.parametrize(
    ("outline", "word"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], r"itself or bounds no area at \(0.5, 0.5\) m"),
        ([(0, 0), (1, 0), (2, 0)], "crosses itself or bounds no area"),
        ([(0, 0), (1, 0)], "is no list of three corners or more"),
        (rectangle(1, 1).with_holes(disc(0.2, (0.5, 0))), r"hole 1 is not within it at \(0.5, "),
        (rectangle(1, 1).with_holes(disc(0.2), disc(0.2, (2, 0))), r"hole 2 .* at \(2.2, 0\) m"),
        (rectangle(1, 1).with_holes(disc(0.2), disc(0.1)), "two holes meet"),
        (7, "is no list of three corners"),
        ([(0, 0), (1, "a"), (2, 3)], "give numbers or expressions in m"),
    ],
)  # fmt: skip
def test_outlines_that_are_refused(outline: Any, word: str) -> None:
    model = Model("m")
    model.body("b", outline=outline, thickness=0.1, density=1.0)
    assert any(re.search(word, problem) for problem in model.problems), model.problems
    assert all("body 'b': outline" in problem for problem in model.problems)


@pytest.mark.parametrize(
    "given",
    [
        {"mass": 1.0, "inertia": 0.1}, {"thickness": 1.0}, {"density": 1.0},
        {"mass": 1.0, "thickness": 0.1, "density": 1.0},
    ],
)  # fmt: skip
def test_an_outline_says_the_inertia_alone(given: dict[str, float]) -> None:
    model = Model("m")
    model.body("b", outline=rectangle(1, 1), **given)
    assert "the inertia follows from its outline" in model.problems[0]
    model = Model("m")
    model.body("b", 1.0, 1.0, density=3.0)
    assert "but no outline" in model.problems[0]


class Drawn(Model):
    """The bodies of the examples, plates whose drawings have their centres of mass somewhere."""

    def __init__(self, at: dict[str, tuple[float, float]]) -> None:
        super().__init__("example")
        for name, (x, y) in at.items():
            outline = rectangle(0.5, 0.4, (x, y))
            body = self.body(name, outline=outline, thickness=0.1, density=100.0)
            sx, sy = (self.parameter(f"{name}_s{axis}", 0.3, unit="m") for axis in "xy")
            setattr(self, name, body)
            setattr(self, "P" if name == "i" else "Q", body.at(sx + x, sy + y))


def drawn_away(kind: str, at: dict[str, tuple[float, float]], monkeypatch: Any) -> Interpreted:
    monkeypatch.setattr(pages, "Pair", lambda _: Drawn(at))
    return Interpreted(pages.example_of(kind).model)


WITH_PLACES = (".at(", "curve(", "circle(", "polar(", "clearance")  # the last takes ten seconds
KINDS = sorted(
    kind for role in ("joint", "driver", "force") for kind in library_kinds(role)
    if not any(word in pages.example_of(kind).source for word in WITH_PLACES)
)  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_no_element_notices_where_a_drawing_has_its_origin(kind: str, monkeypatch: Any) -> None:
    here = drawn_away(kind, {"i": (0, 0), "j": (0, 0)}, monkeypatch)
    away = drawn_away(kind, {"i": (0.5, -0.25), "j": (-1.0, 2.0)}, monkeypatch)
    same_kernels(here, away)


def same_kernels(one: Interpreted, other: Interpreted) -> None:
    state = one.state(3)
    more = {"lam": np.linspace(0.5, 1.5, one.m), "w": np.ones(one.n), "a": np.ones(one.n)}
    for kernel in {k.name for k in one.program.kernels} - {"constants"}:
        values, others = (each.slots(kernel, state, **more) for each in (one, other))
        assert values.keys() == others.keys()
        for slot, expected in values.items():
            assert_allclose(others[slot], expected, rtol=1e-9, atol=1e-9, err_msg=kernel)


def cam(x: float, y: float) -> Model:
    """Three cams on a body whose drawing has its centre of mass at (x, y)."""
    model = Model("cam")
    e = model.parameter("e", 0.1, unit="m")
    outline = rectangle(0.5, 0.4, (x, y))
    body = model.body("body", outline=outline, thickness=0.1, density=100.0)
    others = [model.body(name, 1.0, 0.1) for name in ("flat", "round", "pin")]
    model.cam_flat_follower("A", body.circle(0.2, (x + e, y)), others[0].at(0, 0.3), axis=(1, 0))
    model.cam_follower("B", body.circle(0.3, (x, y)), others[1].circle(0.25))
    curve = body.curve(x + 0.3 * sympy.cos(alpha), y + 0.2 * sympy.sin(alpha))
    model.point_follower("C", curve, others[2].at(0, 0))
    model.scene("s")
    return model


def test_curves_are_given_in_the_axes_of_the_drawing() -> None:
    same_kernels(Interpreted(cam(0, 0)), Interpreted(cam(0.5, -0.25)))


def pendulum(link: Body, at: Any, model: Model) -> Model:
    model.revolute("hinge", model.ground.at(0, 0), at(0, 0))
    model.track("tip", at(L, 0.01))
    spring = {"stiffness": 40.0, "free_length": 0.1, "damping": 0.3}
    model.spring("spring", model.ground.at(0.5, 0.2), at(L / 2, 0.02), **spring)
    model.scene("swing", ["gravity", "spring"], start={link.phi: 0.3}, outputs=["all"])
    return model


def test_a_pendulum_moves_as_one_whose_mass_and_places_are_given(tmp_path: Path) -> None:
    drawn = Model("drawn", gravity=(0, -9.81))
    outline = bar(L, W).with_holes(disc(0.01, (0.2, 0)))
    link = drawn.body("link", outline=outline, thickness=THICKNESS, density=DENSITY)
    area, polar = slotted_bar(L, W)
    hole = pi * 1e-4
    x = (area * L / 2 - hole * 0.2) / (area - hole)
    polar += area * (x - L / 2) ** 2 - hole * (1e-4 / 2 + (x - 0.2) ** 2)
    by_hand = Model("by_hand", gravity=(0, -9.81))
    heavy = DENSITY * THICKNESS
    rod = by_hand.body("link", heavy * (area - hole), heavy * polar)
    models = (pendulum(link, link.at, drawn), pendulum(rod, lambda a, b: rod.at(a - x, b), by_hand))
    runs = [load(model, folder=tmp_path).simulate(1.0, rtol=1e-11, atol=1e-12) for model in models]
    one, other = (run.data for run in runs)
    for name, values in other.data_vars.items():
        if values.dtype == float and "residual" not in str(name):
            size = float(abs(values).max())
            assert_allclose(one[name], values, rtol=0, atol=1e-9 * max(size, 1e-3), err_msg=name)
    assert_allclose(runs[0].reaction("hinge", "fy"), runs[1].reaction("hinge", "fy"), atol=1e-9)


def test_the_picture_shows_the_outline_with_its_holes() -> None:
    model = Model("plate")
    w = model.parameter("w", 1.0, unit="m")
    plate = rectangle(w, 0.6, (w / 2, 0.3)).with_holes(disc(0.1, (0.7, 0.3)), disc(0.1, (0.3, 0.3)))
    body = model.body("plate", outline=plate, thickness=0.1, density=100.0)
    model.revolute("A", model.ground.at(0, 0), body.at(0, 0))
    for values, width in ((None, 1.0), ({"w": 2.0}, 2.0)):
        picture = declared_picture(model, None, values)
        (polygon,) = picture.bodies[1].outlines
        assert not picture.bodies[1].is_derived
        signed = (polygon.conj() * np.roll(polygon, -1)).imag.sum() / 2
        assert signed == pytest.approx(width * 0.6 - 2 * 24 * 0.01 * sin(2 * pi / 48))
        assert abs(picture.placed(polygon, 1)).min() == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"mass": 1.0, "density": 2.0}, "mass= and density= are both given"),
        ({"thickness": 1.0}, "density= is missing"),
        ({"density": 1.0}, "thickness= is missing"),
        ({"mass": 1.0, "inertia": 1.0}, "inertia= is given as well"),
    ],
)
def test_what_of_a_plate_is_missing_or_too_much(given: dict[str, float], word: str) -> None:
    model = Model("m")
    model.body("plate", outline=rectangle(1, 1).with_holes(disc(0.2)), **given)
    assert word in model.problems[0]


def test_an_outline_shows_itself_in_a_few_words() -> None:
    assert repr(rectangle(1, 1).with_holes(disc(0.2))) == "Outline(4 edges, 1 holes)"


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: disc(-1), "disc: a size is -1; give one that is more than 0"),
        (lambda: rectangle(0, 1), "rectangle: a size is 0"),
        (lambda: bar(0.3, -0.1), "bar: a size is -0.1"),
        (lambda: disc(1, center=3), "disc: 3 is no place"),
        (lambda: rectangle(1, 2, 3), "rectangle: 3 is no place"),
        (lambda: bar(1, 0.1, start=2), "bar: 2 is no place"),
        (lambda: disc(None), "disc: .*None: give numbers or expressions in m"),
        (lambda: read_outline(3), "There is no file '3'"),
    ],
)
def test_measures_that_are_none(make: Any, word: str) -> None:
    with pytest.raises(ModelError, match=word):
        make()


def test_an_outline_that_is_drawn_keeps_its_holes() -> None:
    ring, model = disc(0.1).with_holes(disc(0.05)), Model("drawn")
    (seen,) = model.body("seen", draw=ring).outlines
    assert len(seen) > len(ring) + len(ring.holes[0])
    assert model.body("both", draw=[ring, disc(0.02)]).outlines[0] == seen
