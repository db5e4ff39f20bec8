"""`random_linkage`: a linkage for a seed, its guesses far off; some of them cannot close."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen import Model, t

KINDS = ("four-bar", "slider-crank", "Watt six-bar", "Stephenson six-bar")
DRIVES = ("angle", "cylinder", "none")
FAR = 1.0  # rad and m: the largest errors of guesses
IMPOSSIBLE = 0.25  # of all linkages
AWAY = 20.0  # m; no pose of bars of less than 3 m reaches so far
LONG = 10.0  # m; of a cylinder that would have to be


@dataclass
class Linkage:
    """A linkage with numbers; `closes` says whether there is a closed position."""

    kind: str
    drive: str
    closes: bool
    model: Model


def random_linkage(seed: int) -> Linkage:
    """The linkage of a seed, whose points are drawn where they close."""
    random = np.random.default_rng([7, seed])
    kind, drive = KINDS[seed % 4], DRIVES[seed // 4 % 3]
    closes = bool(random.random() > IMPOSSIBLE)
    pins = {"O": np.zeros(2), "A": _around(random, np.zeros(2), 0.3, 1.0)}
    bars: dict[str, tuple[str, ...]] = {"crank": ("O", "A")}
    if kind == "slider-crank":
        pins["B"] = _around(random, pins["A"], 1.0, 2.0)
        bars["rod"] = ("A", "B")
    else:
        pins["B"], pins["C"] = (_around(random, pins[p], 0.5, 1.5) for p in ("A", "O"))
        bars |= {"coupler": ("A", "B"), "rocker": ("B", "C")}
    if "six" in kind:  # two bars more, on the rocker or on the coupler
        pins["D"], pins["F"] = (_around(random, pins[p], 0.4, 1.2) for p in ("B", "C"))
        pins["E"] = _around(random, pins["F"], 0.5, 1.5)
        bars["rocker" if kind.startswith("Watt") else "coupler"] += ("D",)
        bars |= {"link": ("D", "E"), "arm": ("E", "F")}
    poses = {
        name: np.append(pins[ends[0]] + random.normal(0.0, 0.2, 2), random.uniform(-np.pi, np.pi))
        for name, ends in bars.items()
    }
    if kind == "slider-crank":
        poses["slider"] = np.array([*pins["B"], random.uniform(-np.pi, np.pi)])
        bars["slider"] = ("B",)
    model = Model(f"linkage{seed}", gravity=(0, -9.81))
    for name in poses:
        model.body(name, mass=1.0, inertia=0.1)
    away = 0.0 if closes or drive == "cylinder" else AWAY
    grounded = [pin for pin in "OCF" if pin in pins]
    for pin, place in pins.items():
        holders = [_point(model, name, place, poses) for name, ends in bars.items() if pin in ends]
        if pin in grounded:
            moved = place + away * (pin == grounded[-1] != "O")
            holders.insert(0, model.ground.at(*moved.tolist()))
        for k, other in enumerate(holders[1:]):
            model.revolute(f"{pin}{k}", holders[0], other)
    if kind == "slider-crank":
        angle = float(poses["slider"][2])
        axis = np.array([np.cos(angle), np.sin(angle)])
        line = pins["B"] + random.normal() * axis + away * np.array([-axis[1], axis[0]])
        rail, slider = model.ground.at(*line.tolist()), model.bodies["slider"]
        model.translational("guide", rail, slider, axis=tuple(axis.tolist()), angle=angle)
    crank, turned = model.bodies["crank"], float(poses["crank"][2])
    if drive == "angle":
        model.driver("drive", crank.phi, turned + 0.1 * t)
    elif drive == "cylinder":
        eye = _around(random, pins["O"], 1.0, 2.0)
        length = float(np.linalg.norm(pins["A"] - eye)) if closes else LONG
        end = _point(model, "crank", pins["A"], poses)
        model.distance_driver("drive", model.ground.at(*eye.tolist()), end, length + 0.01 * t)
    guess = {}
    for name, pose in poses.items():
        guessed = pose + FAR * random.uniform(-1.0, 1.0, 3)
        guess |= dict(zip(model.bodies[name].coordinates, guessed.tolist(), strict=True))
    start = {}
    if drive == "none" and random.random() < 0.5:
        start = {crank.phi: turned}
        del guess[crank.phi]
    drivers = [] if drive == "none" else ["drive"]
    effects, outputs = ["gravity"], ["energy"]
    model.scene("run", effects, drivers, start=start, guess=guess, outputs=outputs)
    return Linkage(kind, drive, closes, model)


def _around(random: np.random.Generator, centre: Any, least: float, most: float) -> Any:
    angle, length = random.uniform(-np.pi, np.pi), random.uniform(least, most)
    return centre + length * np.array([np.cos(angle), np.sin(angle)])


def _point(model: Model, name: str, place: Any, poses: dict[str, Any]) -> Any:
    """The point of a body that is at a place of the plane in its pose."""
    *origin, angle = poses[name]
    c, s = np.cos(angle), np.sin(angle)
    return model.bodies[name].at(*(np.array([[c, s], [-s, c]]) @ (place - origin)).tolist())
