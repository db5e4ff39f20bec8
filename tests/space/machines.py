"""Machines in space of the tests: a free body, tops, slider-cranks, an arm."""

from codegen import Model

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
