"""Generated modules written by hand for the runtime's tests, with dense hand-derived kernels.

They obey the contract of a generated module but owe nothing to the code generator, so that the
runtime is judged against equations derived on paper.
"""

import hashlib
import os
from dataclasses import dataclass, field
from pathlib import Path

from codegen.files.build_records import Input, Record, generator_state, write_record
from codegen.files.generated_modules import text_hash

DATA = Path(__file__).parent / "data"
REVOLUTE_X, REVOLUTE_Y, ABSOLUTE, DRIVER = range(4)


@dataclass
class Mechanism:
    """A planar mechanism of bars; a point lies on its bar's axis, at a distance found in p."""

    model: str
    scene: str
    bodies: dict[str, tuple[str, str]]
    parameters: list[tuple[str, float, str, str]]
    start: list[tuple[str, float, str]] = field(default_factory=list)
    constants: list[tuple[str, str | None, float]] = field(default_factory=list)
    gravity: tuple[str | None, str | None] = (None, None)
    rows: list[tuple[str, str, str, int, int, int, int, int]] = field(default_factory=list)
    loads: list[tuple[str, str, str, str | None]] = field(default_factory=list)
    masses: bool = True

    def __post_init__(self) -> None:
        self.coordinates = [
            (f"{body}.{name}", f"{body}.{rate}", unit)
            for body in self.bodies
            for name, rate, unit in (("x", "vx", "m"), ("y", "vy", "m"), ("phi", "omega", "rad"))
        ]
        self._places = [row[0] for row in self.parameters] + [row[0] for row in self.constants]

    def place(self, name: str | None) -> int:
        """Index in p of a parameter or constant; -1 for none."""
        return -1 if name is None else self._places.index(name)

    def coordinate(self, name: str) -> int:
        """Index in q of a coordinate, by its name or its velocity's."""
        return next(i for i, row in enumerate(self.coordinates) if name in row[:2])

    def revolute(self, name: str, first: str, at: str, second: str, at_second: str) -> None:
        """Join two points; `ground` has its points at the origin unless `at` names an x."""
        bodies = list(self.bodies)
        a = bodies.index(first) if first != "ground" else -1
        b = bodies.index(second)
        places = (self.place(at), self.place(at_second))
        self.rows.append((name, "revolute", "x", REVOLUTE_X, a, b, *places))
        self.rows.append((name, "revolute", "y", REVOLUTE_Y, a, b, *places))

    def hold(self, name: str, kind: str, coordinate: str, value: str) -> None:
        """Hold a coordinate at a parameter's value."""
        row = coordinate.split(".")[1]
        index = self.coordinate(coordinate)
        self.rows.append((name, kind, row, ABSOLUTE, index, -1, self.place(value), 0))

    def drive(self, name: str, coordinate: str, offset: str, rate: str) -> None:
        """Move a coordinate as offset + rate t."""
        row = coordinate.split(".")[1]
        index = self.coordinate(coordinate)
        places = (self.place(offset), self.place(rate))
        self.rows.append((name, "driver", row, DRIVER, index, -1, *places))

    def load(self, name: str, coordinate: str, value: str, while_positive: str | None) -> None:
        """Push on a coordinate, always or only while a velocity is positive."""
        self.loads.append((name, coordinate, value, while_positive))

    def text(self, source: tuple[str, str]) -> str:
        """The module's text, its content hash in place."""
        drivers = [row[0] for row in self.rows if row[1] == "driver"]
        switched = [load for load in self.loads if load[3] is not None]
        effects = [("gravity", "gravity")] if self.gravity != (None, None) else []
        literals = {
            "GENERATOR": "linkwright 0.1.0",
            "MODEL": self.model,
            "SCENE": self.scene,
            "FORMULATION": "cartesian",
            "SOURCES": (source,),
            "DECLARATION_SHA256": "0" * 64,
            "BODIES": tuple(self.bodies),
            "COORDINATES": tuple(self.coordinates),
            "CONSTRAINTS": tuple(row[:3] for row in self.rows),
            "PARAMETERS": tuple(self.parameters),
            "CONSTANTS": tuple(row[0] for row in self.constants),
            "EFFECTS": tuple(effects + [(load[0], "force") for load in self.loads]),
            "LEFT_OUT": (),
            "DRIVERS": tuple(drivers),
            "SWITCHES": tuple((load[0], f"{load[3]} > 0") for load in switched),
            "REACTIONS": tuple(
                (row[0], *_component(row[1], row[2])) for row in self.rows if self.masses
            ),
            "POWERS": tuple(
                [(load[0], "effect") for load in self.loads]
                + [(name, "driver") for name in drivers]
            )
            if self.masses
            else (),
            "START": tuple(self.start),
            "JACOBIAN_ROWS": tuple(
                i for i in range(len(self.rows)) for _ in range(len(self.coordinates))
            ),
            "JACOBIAN_COLUMNS": tuple(range(len(self.coordinates))) * len(self.rows),
            "MASS_ROWS": tuple(range(len(self.coordinates))),
            "MASS_COLUMNS": tuple(range(len(self.coordinates))),
            "OPERATIONS": (("accelerations", 1),),
            "OPTIONS": {"cache": True, "error_model": "numpy"},
        }
        modes = [load[0] for load in switched]
        tables = {
            "N": len(self.coordinates),
            "M": len(self.rows),
            "NP": len(self.parameters),
            "REVOLUTE_X": REVOLUTE_X,
            "REVOLUTE_Y": REVOLUTE_Y,
            "ABSOLUTE": ABSOLUTE,
            "DRIVER": DRIVER,
            "KINDS": [row[3] for row in self.rows],
            "FIRST": [row[4] for row in self.rows],
            "SECOND": [row[5] for row in self.rows],
            "FIRST_POINT": [row[6] for row in self.rows],
            "SECOND_POINT": [row[7] for row in self.rows],
            "SCALED": [self.place(row[1]) for row in self.constants],
            "MASSES": [
                self.place(mass) if k < 2 else self.place(inertia)
                for mass, inertia in self.bodies.values()
                for k in range(3)
            ],
            "GRAVITY": [*(self.place(name) for name in self.gravity), -1],
            "LOADED": [self.coordinate(load[1]) for load in self.loads],
            "LOADS": [self.place(load[2]) for load in self.loads],
            "SWITCH_OF": [modes.index(load[0]) if load[0] in modes else -1 for load in self.loads],
            "SWITCHED_BY": [self.coordinate(load[3]) for load in switched],
        }
        lines = ['"""Kernels written by hand for tests."""', "", "import numba"]
        lines += ["import numpy as np", ""]
        lines += [f"{name} = {value!r}" for name, value in literals.items()]
        for name, value in tables.items():
            if isinstance(value, list):
                lines.append(f"{name} = np.array({value!r}, dtype=np.int64)")
            else:
                lines.append(f"{name} = {value!r}")
        factors = [row[2] for row in self.constants]
        lines.append(f"FACTORS = np.array({factors!r}, dtype=np.float64)")
        body = (DATA / "kernels.txt").read_text()
        if not self.masses:
            body = _without_masses(body)
        elif switched:
            body += (DATA / "switching.txt").read_text()
        header = "# Written by hand for tests of the runtime.\n# content-sha256: "
        rest = "\n" + "\n".join(lines) + "\n\n\n" + body
        digest = hashlib.sha256((header + "0" * 64 + rest).encode()).hexdigest()
        return header + digest + rest

    def write(self, folder: Path) -> Path:
        """Write a stand-in model file and the generated module under `folder`; return the model."""
        model = folder / "models" / f"{self.model}.py"
        write_whole(model, f'model = Model("{self.model}")\nmodel.scene("{self.scene}")\n')
        source = (f"models/{model.name}", hashlib.sha256(model.read_bytes()).hexdigest())
        module, text = folder / "generated" / f"{self.model}__{self.scene}.py", self.text(source)
        write_whole(module, text)
        inputs = (Input("file", str(model.resolve()), source[1]),)
        scenes = (self.scene,)
        write_record(module, Record(text_hash(text), generator_state(), scenes, inputs, ()))
        return model


def write_whole(path: Path, text: str) -> None:
    """Write a file that others read meanwhile, if it is not there already."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text() != text:
        whole = path.with_suffix(f".{os.getpid()}")
        whole.write_text(text)
        whole.replace(path)


def _component(kind: str, row: str) -> tuple[str, str]:
    if row == "phi":
        return ("torque", "N m")
    return (f"f{row}", "N")


def _without_masses(body: str) -> str:
    """Drop the kernels that need masses; accelerations then solves Phi_q a = gamma."""
    kept = []
    for part in body.split("\n\n\n"):
        name = part.split("def ")[1].split("(")[0]
        if name in ("mass", "applied_forces", "potential", "potential_gradient"):
            continue
        if name in ("kinetic_energy", "powers", "reactions", "accelerations"):
            continue
        kept.append(part.rstrip())
    return "\n\n\n".join(kept) + "\n\n\n" + (DATA / "driven_accelerations.txt").read_text()


def pendulum(scene: str = "swing", *, driven: bool = False) -> Mechanism:
    """A bar pinned at one end; phi = 0 points along x, gravity along -y."""
    machine = Mechanism(
        model="rod_pendulum" if not driven else "driven_pendulum",
        scene=scene,
        bodies={"bar": ("m", "J")},
        parameters=[
            ("m", 2.0, "kg", "positive"),
            ("J", 0.5, "kg m^2", "positive"),
            ("l", 1.0, "m", "positive"),
            ("gx", 0.0, "m/s^2", ""),
            ("gy", -9.81, "m/s^2", ""),
            ("phi0", 0.5, "rad", ""),
            ("omega0", 2.0, "rad/s", ""),
        ],
        constants=[("0", None, 0.0), ("-l", "l", -1.0)],
        gravity=("gx", "gy"),
        start=[("bar.phi", 0.5, "fixed"), ("bar.omega", 0.0, "fixed")],
    )
    machine.revolute("pin", "ground", "0", "bar", "-l")
    if driven:
        machine.start = [("bar.phi", 0.4, "guess")]
        machine.drive("motor", "bar.phi", "phi0", "omega0")
    return machine


def slider_crank(
    scene: str = "free",
    *,
    driven: bool = False,
    masses: bool = True,
    gas: bool = False,
    twice: bool = False,
) -> Mechanism:
    """The book's slider-crank compressor; `twice` guides the slider's angle a second time."""
    machine = Mechanism(
        model=f"sc_{scene}",
        scene=scene,
        bodies={"crank": ("m1", "J1"), "rod": ("m2", "J2"), "slider": ("m3", "J3")},
        parameters=[
            ("m1", 200.0, "kg", "positive"),
            ("J1", 450.0, "kg m^2", "positive"),
            ("m2", 35.0, "kg", "positive"),
            ("J2", 35.0, "kg m^2", "positive"),
            ("m3", 25.0, "kg", "positive"),
            ("J3", 0.02, "kg m^2", "positive"),
            ("r", 2.0, "m", "positive"),
            ("l", 3.5, "m", "positive"),
            ("gx", 0.0, "m/s^2", ""),
            ("gy", -9.81, "m/s^2", ""),
            ("phi0", 0.7853981633974483, "rad", ""),
            ("omega0", 6.283185307179586, "rad/s", ""),
            ("push", -50000.0, "N", ""),
            ("tilt", 0.0, "rad", ""),
            ("far", 10.0, "m", ""),
        ],
        constants=[("0", None, 0.0), ("l/2", "l", 0.5), ("-l/2", "l", -0.5)],
        gravity=("gx", "gy"),
        masses=masses,
    )
    machine.revolute("A", "ground", "0", "crank", "0")
    machine.revolute("B", "crank", "r", "rod", "-l/2")
    machine.revolute("C", "rod", "l/2", "slider", "0")
    machine.hold("guide", "translational", "slider.y", "0")
    machine.hold("guide", "translational", "slider.phi", "0")
    if twice:
        machine.hold("second_guide", "absolute phi", "slider.phi", "tilt")
    if driven:
        machine.drive("crank_drive", "crank.phi", "phi0", "omega0")
    if gas:
        machine.load("gas", "slider.x", "push", "slider.vx")
    machine.start = [
        ("crank.phi", 0.8, "guess"),
        ("rod.x", 3.0, "guess"),
        ("rod.phi", -0.4, "guess"),
        ("slider.x", 4.6, "guess"),
    ]
    return machine


def far_slider(scene: str) -> Mechanism:
    """A slider-crank whose slider is held where the rod does not reach."""
    machine = slider_crank(scene)
    machine.hold("stop", "absolute x", "slider.x", "far")
    return machine


def overdriven(scene: str) -> Mechanism:
    """A slider-crank with two drivers for its one freedom, in agreement."""
    machine = slider_crank(scene, driven=True)
    machine.drive("second_drive", "crank.phi", "phi0", "omega0")
    return machine


def pushed(scene: str) -> Mechanism:
    """A slider-crank with a constant push on the slider, which has no potential here."""
    machine = slider_crank(scene)
    machine.load("press", "slider.x", "push", None)
    return machine


def runaway(scene: str) -> Mechanism:
    """A bar in the plane of a table, with a torque that nothing balances."""
    machine = pendulum(scene)
    machine.model = "runaway"
    machine.gravity = ("gx", "gx")
    machine.load("torque", "bar.phi", "omega0", None)
    return machine


def double(scene: str) -> Mechanism:
    """Two bars in a row, the upper one driven; its pins are at its centre and at l."""
    machine = Mechanism(
        model="double",
        scene=scene,
        bodies={"upper": ("m", "J"), "lower": ("m", "J")},
        parameters=[
            ("m", 2.0, "kg", "positive"),
            ("J", 0.5, "kg m^2", "positive"),
            ("l", 1.0, "m", "positive"),
            ("gx", 0.0, "m/s^2", ""),
            ("gy", -9.81, "m/s^2", ""),
            ("phi0", 0.5, "rad", ""),
            ("omega0", 2.0, "rad/s", ""),
        ],
        constants=[("0", None, 0.0), ("-l", "l", -1.0)],
        gravity=("gx", "gy"),
        start=[("upper.phi", 0.5, "guess"), ("lower.phi", -1.0, "guess")],
    )
    machine.revolute("pin", "ground", "0", "upper", "0")
    machine.revolute("elbow", "upper", "l", "lower", "-l")
    machine.drive("motor", "upper.phi", "phi0", "omega0")
    return machine


def parallelogram(scene: str) -> Mechanism:
    """A platform on three equal cranks, all pinned to a base that is held."""
    bodies = ("base", "first", "second", "third", "platform")
    machine = Mechanism(
        model="parallelogram",
        scene=scene,
        bodies=dict.fromkeys(bodies, ("m", "J")),
        parameters=[
            ("m", 2.0, "kg", "positive"),
            ("J", 0.5, "kg m^2", "positive"),
            ("l", 2.0, "m", "positive"),
            ("r", 1.0, "m", "positive"),
            ("third", 1.0, "m", "positive"),
            ("gx", 0.0, "m/s^2", ""),
            ("gy", -9.81, "m/s^2", ""),
        ],
        constants=[("0", None, 0.0), ("-l", "l", -1.0)],
        gravity=("gx", "gy"),
        start=[
            ("first.phi", 1.0, "guess"),
            ("second.phi", 1.0, "guess"),
            ("third.phi", 1.0, "guess"),
            ("second.x", -2.0, "guess"),
            ("third.x", 2.0, "guess"),
            ("platform.x", 0.5, "guess"),
            ("platform.y", 0.8, "guess"),
        ],
    )
    for coordinate in ("x", "y", "phi"):
        machine.hold(f"hold_{coordinate}", "absolute", f"base.{coordinate}", "0")
    for name, at, length in (("first", "0", "r"), ("second", "-l", "r"), ("third", "l", "third")):
        machine.revolute(f"{name}_pin", "base", at, name, "0")
        machine.revolute(f"{name}_top", name, length, "platform", at)
    return machine


def loose(scene: str) -> Mechanism:
    """A stone that falls."""
    return Mechanism(
        model="loose",
        scene=scene,
        bodies={"stone": ("m", "J")},
        parameters=[
            ("m", 2.0, "kg", "positive"),
            ("J", 0.5, "kg m^2", "positive"),
            ("gx", 0.0, "m/s^2", ""),
            ("gy", -9.81, "m/s^2", ""),
        ],
        gravity=("gx", "gy"),
    )
