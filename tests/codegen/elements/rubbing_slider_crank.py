"""A slider-crank with friction in all its joints."""

from codegen import Model

MU, RADIUS, BEARING = 0.3, 0.15, 0.4


def rubbing_slider_crank(creep: float | None = None) -> Model:
    """Its frictions stick, or creep below the speed `creep`, m/s or rad/s."""
    model = Model("rubbing", gravity=(0, -9.81))
    crank = model.body("crank", mass=2.0, inertia=0.4)
    rod = model.body("rod", mass=3.0, inertia=0.5)
    slider = model.body("slider", mass=1.0, inertia=0.1)
    joints = [
        model.translational("guide", model.ground, slider, axis=(1, 0)),
        model.revolute("a", model.ground.at(0, 0), crank.at(0, 0)),
        model.revolute("b", crank.at(0.5, 0), rod.at(-0.8, 0)),
        model.revolute("c", rod.at(0.8, 0), slider.at(0.1, 0.2)),
    ]
    for k, joint in enumerate(joints):
        size = {"length": BEARING} if k == 0 else {"radius": RADIUS}
        model.friction(f"rub_{joint.name}", joint, MU, creep, **size)
    model.torque("motor", crank, 60.0)
    return model
