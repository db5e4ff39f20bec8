"""A roller chain on two sprockets, whose every roller may meet every sprocket.

         o---o---o---o---o---o---o---o
       o   _                           o
      o  /   \\                    _     o
      o | (+) | driving  driven  (+)   o
      o  \\ _ /                         o
       o                             o
         o---o---o---o---o---o---o---o

Rollers of 0.2 kg at a pitch of 25.4 mm, held together by links without mass, run round two
sprockets with 20 and 30 teeth for every 100 rollers. A sprocket is a wave in
polar coordinates: the gap of a roller at the distance r from the axis is

    g = r - R - h (1 - cos z α)/2,

α the angle from a seat, R the pitch radius, z the number of teeth. A contact with spring and
damper acts along the gradient of g, so that the flank of a tooth carries the torque. Every roller
has a contact with both sprockets, as nobody says beforehand which of them meet.

At the start the rollers lie in their seats and the straight spans between them are free of load.
The smaller sprocket is driven, from rest to 10 rad/s with the time constant 0.1 s; a torque
in proportion to its speed brakes the other.

`roller_chain(n)` declares the chain with n rollers, a multiple of ten; the file's own has thirty.

Scenes
------
drive
    The motion from rest.
"""

from collections.abc import Iterator
from math import cos, pi, sin

from sympy import atan2, exp, sqrt
from sympy import cos as cosine

from codegen import Model, disc, t

PITCH = 0.0254  # m, between the rollers of a chain 16 B
ROLLER, WHEEL = 0.2, 5.0  # kg
TOOTH = 0.3 * PITCH
"""Height h of the teeth, m."""
STIFFNESS = 2e5  # N/m
DAMPING = 80.0  # N s/m, a fifth of the critical damping of a roller
RISE = 0.1
"""Time constant of the drive, s."""


def teeth(rollers: int) -> tuple[int, int]:
    """Teeth of the driving and of the driven sprocket."""
    return rollers // 5, 3 * rollers // 10


def pitch_radius(count: int) -> float:
    """Radius of the circle on which the rollers lie in their seats, m."""
    return PITCH / (2 * sin(pi / count))


def layout(rollers: int) -> tuple[float, list[tuple[float, float]]]:
    """Distance of the axes, and where the rollers lie at the start, from the driving axis, m.

    An odd number of rollers lies on each sprocket, evenly about the line of centres, and the spans
    are straight. As many lie there as the spans, which are nearly tangents, leave room for.
    """
    small, large = teeth(rollers)
    on_small, on_large = 2 * (small // 4) + 1, 2 * (-(-large // 4)) + 1
    links = (rollers - on_small - on_large + 2) // 2
    first = pi - (on_small - 1) * pi / small
    last = (on_large - 1) * pi / large
    x1, y1 = pitch_radius(small) * cos(first), pitch_radius(small) * sin(first)
    x2, y2 = pitch_radius(large) * cos(last), pitch_radius(large) * sin(last)
    span = ((links * PITCH) ** 2 - (y2 - y1) ** 2) ** 0.5
    distance = x1 + span - x2
    return distance, list(_places(small, large, on_small, on_large, links, distance))


def _places(
    small: int, large: int, on_small: int, on_large: int, links: int, distance: float
) -> Iterator[tuple[float, float]]:
    """The rollers, clockwise from the lower end of the wrap on the driving sprocket."""
    wrap = []
    for k in range(on_small):
        angle = pi + (on_small - 1) * pi / small - 2 * pi * k / small
        wrap.append((pitch_radius(small) * cos(angle), pitch_radius(small) * sin(angle)))
    other = []
    for k in range(on_large):
        angle = (on_large - 1) * pi / large - 2 * pi * k / large
        at = pitch_radius(large)
        other.append((distance + at * cos(angle), at * sin(angle)))
    for before, after in ((wrap, other), (other, wrap)):
        yield from before
        (x, y), (x1, y1) = before[-1], after[0]
        for k in range(1, links):
            yield x + (x1 - x) * k / links, y + (y1 - y) * k / links


def roller_chain(rollers: int) -> Model:
    """The chain with so many rollers, and its two sprockets."""
    model = Model(f"roller_chain_{rollers}")
    speed = model.parameter("speed", 10.0, unit="rad/s")
    brake = model.parameter("brake_constant", 0.5, unit="N m s")
    distance, places = layout(rollers)
    wheels = []
    for name, count, x in zip(("driving", "driven"), teeth(rollers), (0.0, distance), strict=True):
        radius = pitch_radius(count)
        teeth_drawn = [
            (r * cos(k * pi / count), r * sin(k * pi / count))
            for k in range(2 * count) for r in (radius - TOOTH * (1 - k % 2),)
        ]  # fmt: skip
        wheel = model.body(name, WHEEL, WHEEL * radius**2 / 2, draw=teeth_drawn)
        model.revolute(f"axle_{name}", model.ground.at(x, 0), wheel.at(0, 0))
        wheels.append((wheel, count, x))
    driving, driven = wheels[0][0], wheels[1][0]
    model.driver("motor", driving.phi, -speed * (t - RISE * (1 - exp(-t / RISE))))
    effects = ["brake"]
    model.torque("brake", on=driven, value=-brake * driven.omega)
    guess = {driven.x: distance}
    chain = [model.particle(f"roller_{k}", ROLLER, draw=disc(TOOTH)) for k in range(rollers)]
    for k, (roller, (x, y)) in enumerate(zip(chain, places, strict=True)):
        model.distance(f"link_{k}", chain[k - 1], roller, PITCH)
        guess |= {roller.x: x, roller.y: y}
        for wheel, count, at in wheels:
            # The seats of the driving sprocket lie about the far side of its axis.
            seat = pi if at == 0.0 else 0.0
            dx, dy = roller.x - at, roller.y
            angle = atan2(dy, dx) - wheel.phi - seat
            crest = TOOTH * (1 - cosine(count * angle)) / 2
            gap = sqrt(dx**2 + dy**2) - pitch_radius(count) - crest
            name = f"{wheel.name}_{k}"
            model.contact(name, gap=gap, stiffness=STIFFNESS, damping=DAMPING, may_pull=False)
            effects.append(name)
    model.scene("drive", effects, ["motor"], guess=guess)
    return model


model = roller_chain(30)
