"""Surfaces: rigid contacts that bounce and rest, friction that sticks, a very stiff contact."""

from functools import cache

import mpmath as mp
import numpy as np

from models.hard.suite import guide, valve_train
from models.hard.suite.bouncing import Base, Bouncing
from models.hard.suite.case import Array, Case, Reference, coordinates
from models.hard.suite.closed import Number
from runtime import Result

G = "9.81"
SHAKEN = np.linspace(0.0, 3.0, 121)
THROWN = np.linspace(0.0, 0.1, 201)
RIDING = 30.0
ROCKING = 10.0
TRAIN = np.linspace(0.0, 0.06, 121)
STIFF, DAMPED = 1e8, 1e5
CAM_SPEED = 260.0


def _changes(run: Result, name: str, *kinds: str) -> Array:
    """Instants of an effect's events of some kinds, s."""
    return np.array(
        [e.time for e in run.events if e.name.startswith(f"{name}:") and e.what in kinds]
    )


@cache
def _dropped() -> Reference:
    with mp.workdps(30):
        rest = float(mp.sqrt(2 / mp.mpf(G)) * 3)
    values, times = np.array([rest, 0.1]), np.array([rest, 10.0])
    return Reference(values, times, 1.0, 20, 1e-14)


def _rest(run: Result) -> Array:
    """When the ball comes to rest, and where it is in the end."""
    rests = _changes(run, "plate", "holds")
    return np.array([rests[0] if len(rests) else np.nan, run.q("ball.y")[-1]])


@cache
def _shaken() -> Reference:
    with mp.workdps(30):
        size, rate = mp.mpf(0.02), mp.mpf(30)
        table = Base(
            lambda t: mp.mpf(0.1) + size * mp.sin(rate * t),
            lambda t: size * rate * mp.cos(rate * t),
            lambda t: -size * rate**2 * mp.sin(rate * t),
        )
        ball = Bouncing(-mp.mpf(9.81), mp.mpf(0), mp.mpf(0), table)
        flight = ball.story(0.15, SHAKEN[-1], 1e-3)
        values = ball.place(flight, SHAKEN)[:, None]
    return Reference(values, SHAKEN, 3.0, 100, 1e-13)


@cache
def _followed() -> Reference:
    with mp.workdps(30):
        e, rate, mass, k = mp.mpf(0.0025), mp.mpf(CAM_SPEED), mp.mpf(0.2), mp.mpf(1000)
        level = mp.mpf(0.0125) + mp.mpf(0.075)

        def turned(t: Number) -> Number:
            return rate * t - mp.pi / 2

        cam = Base(
            lambda t: level + e * mp.sin(turned(t)),
            lambda t: e * rate * mp.cos(turned(t)),
            lambda t: -e * rate**2 * mp.sin(turned(t)),
        )
        # The spring, 60 mm when free, is as long as its seat is above the top of the rod.
        seat = mp.mpf(0.0125) - mp.mpf(0.0025) + mp.mpf(0.15) + mp.mpf(0.04)
        constant = k * (mp.mpf(0.06) - seat + mp.mpf(0.075))
        rod = Bouncing(-mp.mpf(9.81) - constant / mass, k / mass, mp.mpf(0.4), cam)
        flight = rod.story(float(level - e) - 1e-9, THROWN[-1], 2e-5)
        values = rod.place(flight, THROWN)[:, None]
    return Reference(values, THROWN, 10.0, 300, 1e-12)


@cache
def _cycles() -> Reference:
    m, k, kinetic, static, v, g = 1.0, 100.0, 0.2, 0.3, 0.1, float(G)
    w, u = np.sqrt(k / m), (static - kinetic) * m * g / k
    slides, rides = 2.0 * (np.pi - np.arctan(u * w / v)) / w, 2.0 * u / v
    begun = np.arange(200)
    times = static * m * g / (k * v) + (begun + 1) // 2 * slides + begun // 2 * rides
    times = times[times < RIDING]
    # An error of the place by one unit is one of 1/v in the time at which the block tears loose.
    return Reference(times, times, 1.0 / v, 200, 1e-13)


def _rides(run: Result) -> Array:
    """When the block tears loose and is caught, in turn, s."""
    return _changes(run, "belt", "ceased", "holds")


@cache
def _rubbed() -> Reference:
    place, changes = guide.motion(ROCKING, np.pi / 2)
    times = np.array([at for at, _ in changes])
    values = np.append(times, place[0])
    return Reference(values, np.append(times, ROCKING), 30.0, 200, 1e-8)


def _turned(run: Result) -> Array:
    """When friction sticks, lets go or turns, s, and the crank's angle in the end, rad."""
    return np.append([e.time for e in run.events], run.q("crank.phi")[-1])


@cache
def _train() -> Reference:
    lift = valve_train.lift(TRAIN, STIFF, DAMPED)
    # Pressed against the cam by a stiffness K, the rod follows it, whatever a step does to it.
    return Reference(0.085 + lift[:, None], TRAIN, 1.0, 200, 1e-12)


CASES = (
    Case(
        name="ball_dropped",
        hard="A ball that bounces without end in a finite time: the flights shrink by half.",
        see="Rest at √(2h/g) (1 + e)/(1 - e) to 1e-9 s; from then on the plate carries it.",
        model="hard/bouncing_ball",
        scene="dropped",
        t_end=10.0,
        quantity="time of rest in s, y at the end in m",
        measure=_rest,
        reference=_dropped,
        origin="the geometric series",
        sampled=False,
    ),
    Case(
        name="ball_shaken",
        hard="A ball without bounce on a table that shakes it off, again and again.",
        see="Released where the table's acceleration passes g, caught where it comes down.",
        model="hard/bouncing_ball",
        scene="shaken",
        t_end=float(SHAKEN[-1]),
        quantity="y of the ball, m",
        measure=coordinates("ball.y"),
        reference=_shaken,
        origin="parabolas between zeros located in 50 digits",
        parameters={"restitution": 0.0},
    ),
    Case(
        name="follower_thrown",
        hard="A follower that leaves its cam, bounces, and comes to rest on it again.",
        see="Infinitely many impacts in a finite time, three times over.",
        model="hard/contact_follower",
        scene="thrown",
        t_end=float(THROWN[-1]),
        quantity="y of the pushrod, m",
        measure=coordinates("pushrod.y"),
        reference=_followed,
        origin="oscillations between zeros located in 50 digits",
        parameters={"omega": CAM_SPEED},
    ),
    Case(
        name="belt_block",
        hard="A block on a belt that sticks and slips by Coulomb's law, not smoothed.",
        see="It breaks loose and sticks again at the exact instants, however long the run.",
        model="hard/belt_block",
        scene="riding",
        t_end=RIDING,
        quantity="times of breaking loose and of sticking again, s",
        measure=_rides,
        reference=_cycles,
        origin="closed form; an error of position is divided by the belt's speed",
        sampled=False,
    ),
    Case(
        name="guide_friction",
        hard="A slider-crank with friction in its guide, which changes its own normal force.",
        see="Every sticking phase, and the reversal of friction at the dead centres.",
        model="hard/guide_friction",
        scene="rocking",
        t_end=ROCKING,
        quantity="times of sticking, breaking loose and reversing in s, φ1 at the end in rad",
        measure=_turned,
        reference=_rubbed,
        origin="the reduced equation piece by piece, by SciPy, to 1e-8",
        sampled=False,
    ),
    Case(
        name="stiff_train",
        hard="Section 8.5 with a free follower on a contact of 1e8 N/m and 1e5 N s/m.",
        see="Implicit methods take a tenth of the steps, and agree to 1e-6.",
        model="valve_lifter",
        scene="free_follower",
        t_end=float(TRAIN[-1]),
        quantity="y of the pushrod, m",
        measure=coordinates("pushrod.y"),
        reference=_train,
        origin="the reduced equation, by SciPy's Radau at 1e-12",
        tolerances=(1e-4, 1e-6, 1e-8),
        parameters={"K": STIFF, "C": DAMPED},
    ),
)
