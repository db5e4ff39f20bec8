"""`random_mechanism`: a sound mechanism for a seed, with a state at which it is assembled."""

from dataclasses import dataclass, replace
from math import hypot
from typing import Any

import numpy as np

from codegen import Model
from tests.random_mechanisms import modules, parts
from tests.random_mechanisms.applied_effects import (
    add_contact,
    add_drivers,
    add_effects,
    mechanism_of,
    set_laws,
)
from tests.random_mechanisms.declaration import RATES, declare
from tests.random_mechanisms.modules import Host, Module
from tests.random_mechanisms.parts import GROUND
from tests.random_mechanisms.pose_analysis import LEAST_SINGULAR_VALUE, column_sizes, freedoms
from tests.random_mechanisms.pose_builder import PoseBuilder, Scales, less

FAMILIES = ("tree", "series", "parallel", "cams", "wheels", "linkage", "mixed")
PLAIN: dict[str, tuple[str, ...]] = {  # family → its modules, each on the one before
    "plain four-bar": ("four-bar",),
    "plain six-bar": ("four-bar", "four-bar"),
    "plain slider-crank": ("slider-crank",),
    "slider behind a four-bar": ("four-bar", "slider-crank"),
    "plain swinging block": ("swinging block",),
    "plain five-bar": ("five-bar",),
    "plain flat cam": ("flat cam",),
    "pendulum on a four-bar": ("four-bar", "pendulum"),
    "pendulum on a slider-crank": ("slider-crank", "pendulum"),
    "pendulum on a flat cam": ("flat cam", "pendulum"),
    "geared four-bar": ("gear pair", "four-bar"),
    "racked slider-crank": ("rack", "slider-crank"),
}
DRIVEN = ("free", "partly", "wholly")
FRICTION = ("none", "smooth", "sticking")
CONTACTS = ("none", "yielding", "rigid")
MOST_FREEDOMS = 5


@dataclass(frozen=True)
class RandomMechanism:
    """A mechanism, the state at which it is assembled, and what kind it is.

    Attributes
    ----------
    seed, family, driven, friction
        What it was made from; `kind` lists its modules as well.
    parts
        All numbers, from which the dense equations of the tests are made.
    freedoms
        Degrees of freedom that the drivers leave.
    start
        Values of independent coordinates and their velocities, by the names of scenes.
    guess
        Values of all other coordinates.
    horizon
        A few typical times, s.
    """

    seed: int
    family: str
    driven: str
    friction: str
    modules: tuple[str, ...]
    parts: parts.Mechanism
    scales: Scales
    freedoms: int
    start: dict[str, float]
    guess: dict[str, float]
    horizon: float
    scene: str = "run"

    @property
    def kind(self) -> str:
        """The family, its modules, how it is driven and how it rubs."""
        return f"{self.family}: {', '.join(self.modules)}; {self.driven}; friction {self.friction}"

    @property
    def q(self) -> np.ndarray:
        """Positions at t = 0, in the order of `parts.coordinates`."""
        return np.array(self.parts.pose)

    @property
    def v(self) -> np.ndarray:
        """Velocities at t = 0, in the order of `parts.coordinates`."""
        known = dict(self.parts.velocities)
        return np.array([known[name] for name in self.parts.coordinates])

    def model(self) -> Model:
        """The declaration, anew at every call, with the scene `scene`."""
        scene = {"start": self.start, "guess": self.guess}
        return declare(self.parts, f"random_{self.seed}", scene)


def random_mechanism(
    seed: int, family: str | None = None, driven: str | None = None, friction: str | None = None,
    scales: Scales | None = None, contacts: str = "none",
) -> RandomMechanism:  # fmt: skip
    """The mechanism of a seed, the same in every process.

    Parameters
    ----------
    family, driven, friction
        One of `FAMILIES`, `DRIVEN` and `FRICTION`; drawn unless given, friction without sticking.
        A family may be one of `PLAIN` as well, whose modules are always the same.
        One with a single freedom cannot be partly driven, and is free.
    scales
        Typical length, mass and time; drawn within three decades to either side unless given. A
        seed gives the same mechanism in any of them.
    contacts
        One of `CONTACTS`: whether it may run against a stop that yields, or two that are rigid.
    """
    first = np.random.default_rng([seed, 0])
    drawn = [
        str(first.choice(FAMILIES)),
        str(first.choice(DRIVEN, p=(0.5, 0.25, 0.25))),
        str(first.choice(FRICTION[:2])),
    ]
    family, driven, friction = (
        a if a is not None else b for a, b in zip((family, driven, friction), drawn, strict=True)
    )
    sizes = 10.0 ** first.uniform(-3, 3, 3)
    sizes[2] = sizes[2] ** (1 / 3)
    scales = scales if scales is not None else Scales(*map(float, sizes))
    attempt = 0
    while True:  # a draw whose joints are nearly dependent in its pose is drawn anew
        attempt += 1
        build = PoseBuilder(np.random.default_rng([seed, attempt]), scales)
        names = _compose(build, family)
        found = freedoms(mechanism_of(build), scales.length)
        if names and found.least > LEAST_SINGULAR_VALUE and 0 < found.count <= MOST_FREEDOMS:
            break
    velocities = _velocities(build, found.allowed, found.names)
    wanted = {"free": 0, "wholly": found.count}.get(driven, found.count // 2)
    add_drivers(build, wanted)
    set_laws(build, velocities)
    add_effects(build, friction)
    for _ in range(CONTACTS.index(contacts)):
        add_contact(build, contacts == "rigid")
    return _with_start(build, velocities, seed, family, friction, names)


def _with_start(
    build: PoseBuilder, velocities: np.ndarray, seed: int, family: str, friction: str,
    names: tuple[str, ...],
) -> RandomMechanism:  # fmt: skip
    """The mechanism with its start values."""
    mechanism = mechanism_of(build)
    left = freedoms(mechanism, build.scales.length)
    coordinates = mechanism.coordinates
    speeds = tuple(zip(coordinates, velocities.tolist(), strict=True))
    known = dict(zip(coordinates, mechanism.pose, strict=True))
    start = {}
    for name in left.independent():
        owner, letter = name.split(".")
        start[name] = known[name]
        start[f"{owner}.{RATES[letter]}"] = dict(speeds)[name]
    moved = any(isinstance(joint, parts.DRIVERS) for joint in build.joints)
    driven = "free" if not moved else "partly" if left.count else "wholly"
    return RandomMechanism(
        seed, family, driven, friction, names, replace(mechanism, velocities=speeds),
        build.scales, left.count, start, {n: q for n, q in known.items() if n not in start},
        2.0 * build.scales.time,
    )  # fmt: skip


def _velocities(build: PoseBuilder, allowed: Any, names: tuple[str, ...]) -> np.ndarray:
    """Velocities that the joints allow, of about one radian or typical length a typical time."""
    v = allowed @ build.random.normal(size=allowed.shape[1])
    largest = float(np.max(np.abs(v)))
    speed = build.between(0.5, 3.0) / (largest * build.scales.time)
    velocities: np.ndarray = v * speed * column_sizes(names, build.scales.length)
    return velocities


def _compose(build: PoseBuilder, family: str) -> tuple[str, ...]:
    """The parts of a family; answers the modules, or nothing where the draw does not fit."""
    if family == "linkage":
        return _linkage(build)
    if family in PLAIN:
        return _plain(build, PLAIN[family])
    loops, wheels, cams = modules.LOOPS, modules.WHEELS, modules.CAMS
    branches = modules.BRANCHES
    catalogue = {
        "tree": branches,
        "series": loops,
        "parallel": loops,
        "cams": cams | {"four-bar": modules.four_bar, "pendulum": modules.pendulum},
        "wheels": wheels | {"four-bar": modules.four_bar, "bob": modules.bob},
        "mixed": loops | wheels | cams | branches,
    }[family]
    first = modules.crank(build)
    hosts, names = [first], ["crank"]
    for k in range(int(build.random.integers(1, 5 if family == "tree" else 4))):
        choices = list(catalogue) if k else [n for n in catalogue if _leads(family, n)]
        name = build.one_of(*choices)
        host = _host(build, hosts, family)
        if build.is_particle(host.body) and name not in ("pendulum", "bob"):
            continue
        added = _added(build, catalogue[name], host)
        if added is None and name != "planet":
            continue
        hosts += [added] if added is not None else []
        names.append(name)
    return tuple(names) if len(names) > 1 else ()


def _plain(build: PoseBuilder, names: tuple[str, ...]) -> tuple[str, ...]:
    """Modules in a row, each on the last one that is pinned to the ground; all of them or none."""
    hosts = [modules.crank(build)]
    for name in names:
        pinned = [host for host in hosts if host.pivot is not None]
        added = _added(build, modules.ALL[name], pinned[-1])
        if added is None:
            return ()
        hosts.append(added)
    return ("crank", *names)


def _leads(family: str, name: str) -> bool:
    """Whether a module may be the first of its family."""
    leading = {"cams": modules.CAMS, "wheels": modules.WHEELS}
    return name in leading.get(family, (name,))


def _added(build: PoseBuilder, module: Module, host: Host) -> Host | None:
    """A module's host; nothing is left of a module that does not fit there."""
    bodies, joints = len(build.bodies), len(build.joints)
    added = module(build, host)
    if added is None and len(build.joints) == joints:
        del build.bodies[bodies:]
    return added


def _host(build: PoseBuilder, hosts: list[Host], family: str) -> Host:
    """Where a module is attached: in series to the last pinned body, in parallel to the first."""
    if family == "parallel":
        return hosts[0]
    if family in ("tree", "mixed"):
        return hosts[int(build.random.integers(len(hosts)))]
    pinned = [host for host in hosts if host.pivot is not None]
    return pinned[-1]


def _linkage(build: PoseBuilder) -> tuple[str, ...]:
    """Bodies in any poses, pinned in a random tree, and closed by links and pins."""
    count = int(build.random.integers(3, 7))
    size = build.scales.length
    names = []
    for k in range(count):
        parent = int(build.random.integers(k + 1)) - 1
        at = (build.length(-1, 1), build.length(-1, 1)) if parent == GROUND else build.somewhere(
            parent, 0.6 * size
        )  # fmt: skip
        away = (at[0] + build.length(-0.6, 0.6), at[1] + build.length(-0.6, 0.6))
        body = build.body(away, 0.5 * size)
        build.pin(parent, body, at)
    freedom = count
    while freedom > 1 and build.chance(0.85):
        i, j = (int(k) - 1 for k in build.random.choice(count + 1, 2, replace=False))
        here, there = build.somewhere(i, 0.8 * size), build.somewhere(j, 0.6 * size)
        if freedom > 2 and build.chance(0.4) and not _joined(build, i, j):
            build.pin(i, j, there)
            freedom -= 2
            names.append("pin")
        elif hypot(*less(here, there)) > 0.3 * size:
            build.link(i, j, here, there)
            freedom -= 1
            names.append("link")
    return (f"{count} bodies", *names)


def _joined(build: PoseBuilder, i: int, j: int) -> bool:
    """Whether a pin holds the two bodies already; a second one would make them one."""
    pins = [p for p in build.joints if isinstance(p, parts.Revolute)]
    return any({p.i.body, p.j.body} == {i, j} for p in pins)
