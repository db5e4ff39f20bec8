"""Machines in space of the tests: a free body, tops, slider-cranks, loops, an arm."""

import numpy as np
from sympy import cos, pi, sin

from codegen import Model, t
from tests.random_mechanisms.spatial_declaration import declare
from tests.space import dense_machines

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
DOWN = (0, 0, -9.81)


def free_body(omega: tuple[float, float, float]) -> Model:
    """A body that nothing holds, with the principal moments 1, 2 and 3."""
    model = Model("free_body", space=True)
    model.body("rod", 2.0, (1.0, 2.0, 3.0))
    start = {f"rod.omega_{c}": w for c, w in zip("xyz", omega, strict=True)}
    model.scene("spin", start=start)
    return model


def top(
    name: str, mass: float, inertia: tuple[float, float, float], along: tuple[int, int, int],
    omega: tuple[float, float, float], **guess: float,
) -> Model:  # fmt: skip
    """A top whose tip is 1 m behind its centre of mass, along an axis of the body."""
    model = Model(name, space=True, gravity=DOWN)
    body = model.body("top", mass, inertia, at=along)
    model.spherical("tip", model.ground, body, at=(0, 0, 0))
    fixed = {f"top.e{k}": float(k == 0) for k in range(4)}
    start = {f"top.omega_{c}": w for c, w in zip("xyz", omega, strict=True)}
    model.scene("spin", effects=["gravity"], start=fixed | start, guess=guess)
    return model


def heavy_top() -> Model:
    """The top of the literature: its axis is y', horizontal at the start."""
    return top("heavy_top", 15.0, (0.234375, 0.46875, 0.234375), Y, (0, 150, -4.61538))


def slider_crank(with_rod: bool) -> Model:
    """Haug's 12.2, with a rod (model 1) or with a distance in place of it (model 2)."""
    model = Model(f"slider_crank_{1 if with_rod else 2}", space=True, gravity=DOWN)
    upright = (0.7042, 0.71, 0, 0)
    crank = model.body("crank", 0.12, (1e-4, 1e-5, 1e-4), at=(0, 0.1, 0.12), axes=upright)
    slider = model.body("slider", 2.0, (1e-4,) * 3, at=(0.2, 0, 0))
    model.revolute("A", model.ground, crank, at=(0, 0.1, 0.12), axis=X)
    pin = crank.at(0, 0.08, 0)
    if with_rod:
        turned = (0.8865, -0.21, 0.4, -0.1)
        rod = model.body("rod", 0.5, (4e-4, 4e-3, 4e-3), at=(0.1, 0.05, 0.1), axes=turned)
        model.spherical("B", pin, rod.at(-0.15, 0, 0))
        axes = rod.along(0, 1, 0), slider.along(0, 0, 1)
        model.universal("C", rod.at(0.15, 0, 0), slider, axes=axes)
    else:
        model.distance("BC", pin, slider, 0.3)
    model.translational("D", model.ground, slider, at=(0.2, 0, 0), axis=X)
    model.scene("run", effects=["gravity"], start={"crank.omega_x": 6.0})
    return model


def bricard() -> Model:
    """Bricard's linkage of the benchmark library of IFToMM: one of its 30 rows follows."""
    model = Model("bricard", space=True, gravity=(0, -9.81, 0))
    corners = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
    axes, along = (Y, Z, X, Y, Z, X), (0, 1, 2, 0, 1)
    bodies = []
    for k, at in enumerate(along):
        middle = tuple((a + b) / 2 for a, b in zip(corners[k], corners[k + 1], strict=True))
        moments = [0.01 / 6 if axis == at else 1.01 / 12 for axis in range(3)]
        bodies.append(model.body(f"b{k + 1}", 1.0, moments, at=middle))
    chain = (model.ground, *bodies, model.ground)
    for k, (corner, axis) in enumerate(zip(corners, axes, strict=True)):
        model.revolute(f"J{k + 1}", chain[k], chain[k + 1], at=corner, axis=axis)
    model.scene("fall", effects=["gravity"])
    return model


def robot_arm() -> Model:
    """Six links in hinges, one behind the other, with axes z y y x y x."""
    model = Model("robot_arm", space=True, gravity=DOWN)
    last, x, z = model.ground, 0.0, 0.0
    for k, axis in enumerate((Z, Y, Y, X, Y, X)):
        at, x, z = (x, 0, z), x + 0.5, z - 0.0625 * (k % 2)
        moments = (0.05, 0.06 - 0.005 * k, 0.02)
        link = model.body(f"link{k + 1}", 5.0 - 0.5 * k, moments, at=(x - 0.25, 0, z))
        model.revolute(f"J{k + 1}", last, link, at=at, axis=axis)
        last = link
    model.scene("fall", effects=["gravity"])
    return model


def driven_slider_crank(length: float) -> Model:
    """Haug's 12.2, model 1, whose crank turns with 2π rad/s about -x from the z axis on."""
    model = Model(f"driven_slider_crank_{round(1000 * length)}", space=True, gravity=DOWN)
    crank = model.body("crank", 0.12, (1e-4, 1e-5, 1e-4), at=(0, 0.1, 0.12), axes=(pi / 2, 0, 0))
    rod = model.body("rod", 0.5, (4e-4, 4e-3, 4e-3), at=(0.1, 0.05, 0.1), axes=(0, 0.7, -0.4))
    slider = model.body("slider", 2.0, (1e-4,) * 3, at=(0.2, 0, 0))
    model.revolute("A", model.ground, crank, at=(0, 0.1, 0.12), axis=X)
    model.spherical("B", crank.at(0, 0.08, 0), rod.at(-length / 2, 0, 0))
    axes = rod.along(0, 1, 0), slider.along(1, 0, 0)
    model.universal("C", rod.at(length / 2, 0, 0), slider, axes=axes)
    model.translational("D", model.ground, slider, at=(0.2, 0, 0), axis=X)
    half = pi / 4 - pi * t  # of the crank's angle, by an equation of one's own
    model.constraint("drive", crank.e0 * sin(half) - crank.e1 * cos(half))
    model.scene("run", effects=["gravity"])
    return model


def governor() -> Model:
    """The flyball governor of the benchmark library of IFToMM, which turns with 2π rad/s."""
    return declare(dense_machines.flyball_governor(), "flyball_governor")


def shafts(bend: float, driven: bool) -> Model:
    """Two shafts at an angle, in hinges and with a universal joint between; the first along x.

    The first is driven with 2 rad/s by an expression, or both turn freely.
    """
    word = "driven" if driven else "free"
    model = Model(f"shafts_{word}_{round(10 * bend)}", space=True)
    along = (float(np.cos(bend)), float(np.sin(bend)), 0.0)
    first = model.body("first", 1.0, (0.1, 0.2, 0.3), at=(-0.5, 0, 0))
    middle = tuple(0.5 * x for x in along)
    second = model.body("second", 2.0, (0.3, 0.2, 0.1), at=middle, axes=(0, 0, bend))
    model.revolute("A", model.ground, first, at=(-1, 0, 0), axis=X)
    model.universal("cross", first, second, at=(0, 0, 0), axes=(Y, Z))
    model.revolute("B", model.ground, second, at=along, axis=along)
    if driven:
        # of half the angle 2 t
        model.constraint("drive", first.e0 * sin(t) - first.e1 * cos(t))
    model.scene("run", start={} if driven else {"first.omega_x": 2.0})
    return model
