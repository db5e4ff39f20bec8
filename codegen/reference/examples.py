"""A small sound model for each kind of the library: the element between two free bodies.

The reference pages show these declarations, their equations and their costs, and the tests hold
every kind to the same laws with them. A declaration is a kind and the lines below it, exactly as a
page shows them; they may use the bodies and points of `Pair`. Its last call is of the method of
`Model` that declares the kind; other methods that do so too stand in parentheses.
"""

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from codegen.declare.element import Constraint, Effect
from codegen.declare.name_rules_and_hints import nearest
from codegen.declare.symbols import alpha, t
from codegen.elements.registry import kinds_of_elements
from codegen.errors import ModelError
from codegen.model import Model
from codegen.plain_values import shown

JOINTS = """
absolute
    model.absolute("level", Q, "y", 0.5)
belt
    r_i, r_j = (model.parameter(r, 0.2, unit="m") for r in ("r_i", "r_j"))
    model.belt("chain", i, j, r_i, r_j)
cam and flat-faced follower
    e = model.parameter("e", 0.1, unit="m")
    model.cam_flat_follower("touch", i.circle(0.5, center=(e, 0)), Q, axis=(1, 0))
cam and follower
    e = model.parameter("e", 0.1, unit="m")
    model.cam_follower("touch", i.circle(0.5, center=(e, 0)), j.circle(0.25))
constraint
    model.constraint("pulley", i.y + 2 * j.y - 1)
distance
    model.distance("wire", P, Q, 2.0)
gear
    model.gear("mesh", i, j, 0.2, 0.3)
point follower
    a = model.parameter("a", 0.6, unit="m")
    model.point_follower("slot", i.curve(a * cos(alpha), 0.5 * sin(alpha)), Q)
rack-and-pinion
    model.rack_and_pinion("teeth", pinion=Q, rack=P, radius=0.2, axis=(1, 0))
relative
    model.relative("beside", P, Q, "x", 0.5)
revolute
    model.revolute("pin", P, Q)
revolute-revolute
    model.revolute_revolute("link", P, Q, 2.0)
revolute-translational
    model.revolute_translational("slot", P, Q, axis=(2, 1))
rolling disc
    model.rolling_disc("roll", disc=Q, line=P, radius=0.2, axis=(1, 0))
screw
    spindle = model.body("spindle", mass=1.0, inertia=0.002)
    model.screw("thread", P, Q, spindle, lead=0.05, axis=(1, 0))
translational
    model.translational("guide", P, Q, axis=(2, 1), angle=0.3)
weld
    model.weld("seam", P, Q, angle=0.3)
"""
DRIVERS = """
distance driver
    model.distance_driver("cylinder", P, Q, 2 + sin(3 * t) / 2)
driver
    omega = model.parameter("omega", 2.0, unit="rad/s")
    model.driver("motor", i.phi, pi / 4 + omega * t)
point driver
    points = [0, 1, 2, 3, 4], [0, 0.3, 0.8, 1, 0.8]
    lift = model.table("lift", *points, units=("s", "m"), kind="spline")
    model.point_driver("hand", Q, "y", lift(t))
relative driver (relative_driver)
    model.rotation_driver("motor", P, Q, 2 * t**2)
translation driver
    model.translation_driver("slide", P, Q, sin(3 * t), axis=(2, 1))
"""
FORCES = """
bushing
    kx, ky = (model.parameter(k, 90.0, unit="N/m") for k in ("k_x", "k_y"))
    cx, cy = (model.parameter(c, 3.0, unit="N s/m") for c in ("c_x", "c_y"))
    model.bushing("rubber", P, Q, stiffness=(kx, ky, 5.0), damping=(cx, cy, 0.2))
clearance joint
    K = model.parameter("K", 1e9)
    mu = model.parameter("mu", 0.1)
    model.clearance_joint("pin", P, Q, clearance=1e-4, stiffness=K, damping=0.5, coefficient=mu,
                          creep=1e-3, radius=0.01)
contact
    k = model.parameter("k", 1e4, unit="N/m")
    c = model.parameter("c", 20.0, unit="N s/m")
    model.contact("stop", P, Q, stiffness=k, damping=c, free_length=1, direction=(1, 0))
dry friction
    mu, mu_s = model.parameter("mu", 0.2), model.parameter("mu_s", 0.3)
    model.dry_friction("rub", P, Q, axis=(1, 0), normal=50.0, coefficient=mu, static=mu_s)
elastic belt
    k = model.parameter("k", 2e4, unit="N/m")
    model.elastic_belt("belt", i, j, 0.1, 0.3, stiffness=k, pretension=50.0)
force
    model.force("brake", on=P, fx=-5 * i.vx, fy=3.0, frame="body")
friction
    mu = model.parameter("mu", 0.2)
    pin = model.revolute("pin", P, Q)
    model.friction("rub", pin, mu, creep=1e-3, radius=0.02)
gear with backlash
    k = model.parameter("k", 5e6, unit="N/m")
    c = model.parameter("c", 200.0, unit="N s/m")
    model.gear_with_backlash("mesh", i, j, 0.1, 0.3, backlash=1e-4, stiffness=k, damping=c)
generalized force
    model.generalized_force("friction", {j.phi: -0.1 * (j.omega - i.omega)})
gravity
    model.gravity("weight", (0, -9.81))
line force
    p = model.table("p", [0, 1, 2, 3, 4], [9e3, 4e3, 2e3, 1e3, 5e2], units=("m", "N"))
    model.line_force("cylinder", P, Q, lambda length, rate: -p(length) + 30 * rate)
motor
    T_s = model.parameter("T_s", 0.8, unit="N m")
    omega_0 = model.parameter("omega_0", 300.0, unit="rad/s")
    model.motor("motor", on=j, from_=i, stall_torque=T_s, no_load_speed=omega_0)
one-way clutch
    model.one_way_clutch("freewheel", driver=i, driven=j)
potential
    model.potential("pendulum", 20 * (1 - cos(i.phi)))
rigid contact
    e = model.parameter("e", 0.5)
    model.contact("stop", P, Q, restitution=e, free_length=1, direction=(1, 0))
spring
    k = model.parameter("k", 200.0, unit="N/m")
    l0 = model.parameter("l_0", 0.8, unit="m")
    c = model.parameter("c", 3.0, unit="N s/m")
    model.spring("strut", P, Q, stiffness=k, free_length=l0, damping=c)
stop
    k = model.parameter("k", 500.0, unit="N m/rad")
    pin = model.revolute("pin", P, Q)
    model.stop("limit", pin, lower=-pi / 3, upper=pi / 2, stiffness=k)
torque
    model.torque("motor", on=j, value=10 - 2 * j.omega, when=j.omega > 0)
torsion spring
    k = model.parameter("k", 30.0, unit="N m/rad")
    c = model.parameter("c", 0.4, unit="N m s/rad")
    model.torsion_spring("coil", i, j, stiffness=k, free_angle=pi / 6, damping=c)
"""


class Pair(Model):
    """Two free bodies `i` and `j` with a point each, `P` on i and `Q` on j, named by parameters."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.i = self.body("i", mass=2.0, inertia=0.5)
        self.j = self.body("j", mass=3.0, inertia=0.7)
        places = {"i_sx": 0.3, "i_sy": -0.2, "j_sx": -0.5, "j_sy": 0.4}
        s = [self.parameter(place, value, unit="m") for place, value in places.items()]
        self.P, self.Q = self.i.at(*s[:2]), self.j.at(*s[2:])


@dataclass(frozen=True)
class Example:
    """An element in a model."""

    model: Model
    element: Constraint | Effect  # the one element that is looked at
    methods: tuple[str, ...] = ()  # methods of `Model` that declare the kind; none for one's own
    source: str = ""  # the lines that declare it; empty where they are in a file of their own


def example_of(kind: str, model: Model | None = None) -> Example:
    """The library's example of a kind, or the first in `model`; ModelError if there is none."""
    registered = kinds_of_elements()
    if kind not in registered:
        raise ModelError(f"there is no element {shown(kind)}; {nearest(kind, registered)}")
    if model is not None:
        for element in _elements(model):
            if element.kind == kind:
                return Example(model, element)
    if kind not in _DECLARATIONS:
        if not registered[kind].is_user_defined:
            raise ModelError(
                f"the library's element '{kind}' has no example; add one to "
                f"{registered[kind].role.upper()}S of codegen/reference/examples.py."
            )
        raise ModelError(
            f"element '{kind}' is one of your own, of {registered[kind].element.__module__}; name "
            "a model file that declares one: linkwright elements --model FILE."
        )
    others, source = _DECLARATIONS[kind]
    pair = Pair("example")
    names = {"model": pair, "alpha": alpha, "t": t, "i": pair.i, "j": pair.j}
    names |= {"P": pair.P, "Q": pair.Q, "sin": sympy.sin, "cos": sympy.cos, "pi": sympy.pi}
    exec(source, names)
    (element,) = (e for e in _elements(pair) if e.kind == kind)
    *_, method = re.findall(r"model\.(\w+)", source)
    return Example(pair, element, (*others, method), source)


def _elements(model: Model) -> Iterator[Constraint | Effect]:
    yield from model.joints.values()
    yield from model.drivers.values()
    yield from model.effects.values()


_DECLARATION = re.compile(r"^(\w.*?)(?: \((.*)\))?\n((?:    .*\n)+)", re.M)
_DECLARATIONS = {
    kind: (tuple(others.split()), textwrap.dedent(lines).rstrip())
    for kind, others, lines in _DECLARATION.findall(JOINTS + DRIVERS + FORCES)
}
"""Kind → the other methods that declare it, and the lines of its declaration."""
