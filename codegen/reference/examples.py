"""A small sound model for each kind of the library: the element between two free bodies.

The reference pages show these declarations, their equations and their costs, and the tests hold
every kind to the same laws with them. An example is a function with the name of the method of
`Model` that declares the kind; it names what it needs of `Pair`.
"""

import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sympy import cos, pi, sin

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, Effect
from codegen.declare.names import nearest
from codegen.declare.symbols import alpha, t
from codegen.elements.registry import kinds_of_elements
from codegen.errors import ModelError
from codegen.model import Model

POINTS = {"i_sx": 0.3, "i_sy": -0.2, "j_sx": -0.5, "j_sy": 0.4}


class Pair(Model):
    """Two free bodies `i` and `j` with a point each, `P` on i and `Q` on j, named by parameters."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.i = self.body("i", mass=2.0, inertia=0.5)
        self.j = self.body("j", mass=3.0, inertia=0.7)
        s = [self.parameter(place, value, unit="m") for place, value in POINTS.items()]
        self.P, self.Q = self.i.at(*s[:2]), self.j.at(*s[2:])


@dataclass(frozen=True)
class Example:
    """An element in a model.

    Attributes
    ----------
    model, element
        The model, and the one element that is looked at.
    methods
        Names of the methods of `Model` that declare the kind; none for an element of one's own.
    source
        The lines that declare it; empty where they are in a file of their own.
    """

    model: Model
    element: Constraint | Effect
    methods: tuple[str, ...] = ()
    source: str = ""


@dataclass(frozen=True)
class _Recipe:
    declare: Callable[..., None]
    methods: tuple[str, ...]


_RECIPES: dict[str, _Recipe] = {}


def example_of(kind: str, model: Model | None = None) -> Example:
    """The example of a kind: the library's, or the first element of it in `model`.

    Raises
    ------
    ModelError
        If there is no such kind, or no example of it.
    """
    registered = kinds_of_elements()
    if kind not in registered:
        raise ModelError(f"there is no element '{kind}'; {nearest(kind, registered)}")
    if model is not None:
        for element in _elements(model):
            if element.kind == kind:
                return Example(model, element)
    if kind not in _RECIPES:
        raise ModelError(
            f"element '{kind}' is one of your own, of {registered[kind].element.__module__}; name "
            "a model file that declares one: python -m codegen elements --model FILE."
        )
    recipe = _RECIPES[kind]
    pair = Pair("example")
    example = inspect.signature(recipe.declare).parameters
    recipe.declare(**{name: pair if name == "model" else getattr(pair, name) for name in example})
    (element,) = (e for e in _elements(pair) if e.kind == kind)
    lines = inspect.getsource(recipe.declare).partition("None:\n")[2]
    return Example(pair, element, recipe.methods, textwrap.dedent(lines).rstrip())


def _elements(model: Model) -> Iterator[Constraint | Effect]:
    yield from model.joints.values()
    yield from model.drivers.values()
    yield from model.effects.values()


def _example(kind: str, *methods: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Note a function as the example of `kind`; the method is called as it is, unless named."""

    def note(declare: Callable[..., None]) -> Callable[..., None]:
        _RECIPES[kind] = _Recipe(declare, methods or (declare.__name__.removeprefix("_"),))
        return declare

    return note


# -- joints ----------------------------------------------------------------------------------


@_example("absolute")
def _absolute(model: Model, Q: Point) -> None:
    model.absolute("level", Q, "y", 0.5)


@_example("cam and flat-faced follower")
def _cam_flat_follower(model: Model, i: Body, Q: Point) -> None:
    e = model.parameter("e", 0.1, unit="m")
    model.cam_flat_follower("touch", i.circle(0.5, center=(e, 0)), Q, axis=(1, 0))


@_example("cam and follower")
def _cam_follower(model: Model, i: Body, j: Body) -> None:
    e = model.parameter("e", 0.1, unit="m")
    model.cam_follower("touch", i.circle(0.5, center=(e, 0)), j.circle(0.25))


@_example("constraint")
def _constraint(model: Model, i: Body, j: Body) -> None:
    model.constraint("pulley", i.y + 2 * j.y - 1)


@_example("distance")
def _distance(model: Model, P: Point, Q: Point) -> None:
    model.distance("wire", P, Q, 2.0)


@_example("gear")
def _gear(model: Model, i: Body, j: Body) -> None:
    model.gear("mesh", i, j, 0.2, 0.3)


@_example("point follower")
def _point_follower(model: Model, i: Body, Q: Point) -> None:
    a = model.parameter("a", 0.6, unit="m")
    model.point_follower("slot", i.curve(a * cos(alpha), 0.5 * sin(alpha)), Q)


@_example("rack-and-pinion")
def _rack_and_pinion(model: Model, P: Point, Q: Point) -> None:
    model.rack_and_pinion("teeth", pinion=Q, rack=P, radius=0.2, axis=(1, 0))


@_example("relative")
def _relative(model: Model, P: Point, Q: Point) -> None:
    model.relative("beside", P, Q, "x", 0.5)


@_example("revolute")
def _revolute(model: Model, P: Point, Q: Point) -> None:
    model.revolute("pin", P, Q)


@_example("revolute-revolute")
def _revolute_revolute(model: Model, P: Point, Q: Point) -> None:
    model.revolute_revolute("link", P, Q, 2.0)


@_example("revolute-translational")
def _revolute_translational(model: Model, P: Point, Q: Point) -> None:
    model.revolute_translational("slot", P, Q, axis=(2, 1))


@_example("translational")
def _translational(model: Model, P: Point, Q: Point) -> None:
    model.translational("guide", P, Q, axis=(2, 1), angle=0.3)


@_example("weld")
def _weld(model: Model, P: Point, Q: Point) -> None:
    model.weld("seam", P, Q, angle=0.3)


# -- drivers ---------------------------------------------------------------------------------


@_example("distance driver")
def _distance_driver(model: Model, P: Point, Q: Point) -> None:
    model.distance_driver("cylinder", P, Q, 2 + sin(3 * t) / 2)


@_example("driver")
def _driver(model: Model, i: Body) -> None:
    omega = model.parameter("omega", 2.0, unit="rad/s")
    model.driver("motor", i.phi, pi / 4 + omega * t)


@_example("point driver")
def _point_driver(model: Model, Q: Point) -> None:
    lift = model.table("lift", [0, 1, 2, 3, 4], [0, 0.3, 1, 0.6, 0], units=("s", "m"))
    model.point_driver("hand", Q, "y", lift(t))


@_example("relative driver", "relative_driver", "rotation_driver")
def _rotation_driver(model: Model, P: Point, Q: Point) -> None:
    model.rotation_driver("motor", P, Q, 2 * t**2)


@_example("translation driver")
def _translation_driver(model: Model, P: Point, Q: Point) -> None:
    model.translation_driver("slide", P, Q, sin(3 * t), axis=(2, 1))


# -- forces ----------------------------------------------------------------------------------


@_example("bushing")
def _bushing(model: Model, P: Point, Q: Point) -> None:
    kx, ky = (model.parameter(k, 90.0, unit="N/m") for k in ("k_x", "k_y"))
    cx, cy = (model.parameter(c, 3.0, unit="N s/m") for c in ("c_x", "c_y"))
    model.bushing("rubber", P, Q, stiffness=(kx, ky, 5.0), damping=(cx, cy, 0.2))


@_example("contact")
def _contact(model: Model, P: Point, Q: Point) -> None:
    k = model.parameter("k", 1e4, unit="N/m")
    c = model.parameter("c", 20.0, unit="N s/m")
    model.contact("stop", P, Q, stiffness=k, damping=c, free_length=1, direction=(1, 0))


@_example("dry friction")
def _dry_friction(model: Model, P: Point, Q: Point) -> None:
    mu, mu_s = model.parameter("mu", 0.2), model.parameter("mu_s", 0.3)
    model.dry_friction("rub", P, Q, axis=(1, 0), normal=50.0, coefficient=mu, static=mu_s)


@_example("force")
def _force(model: Model, i: Body, P: Point) -> None:
    model.force("brake", on=P, fx=-5 * i.vx, fy=3.0, frame="body")


@_example("friction")
def _friction(model: Model, P: Point, Q: Point) -> None:
    mu = model.parameter("mu", 0.2)
    pin = model.revolute("pin", P, Q)
    model.friction("rub", pin, mu, creep=1e-3, radius=0.02)


@_example("generalized force")
def _generalized_force(model: Model, i: Body, j: Body) -> None:
    model.generalized_force("friction", {j.phi: -0.1 * (j.omega - i.omega)})


@_example("gravity")
def _gravity(model: Model) -> None:
    model.gravity("weight", (0, -9.81))


@_example("potential")
def _potential(model: Model, i: Body) -> None:
    model.potential("pendulum", 20 * (1 - cos(i.phi)))


@_example("rigid contact", "contact")
def _rigid_contact(model: Model, P: Point, Q: Point) -> None:
    e = model.parameter("e", 0.5)
    model.contact("stop", P, Q, restitution=e, free_length=1, direction=(1, 0))


@_example("spring")
def _spring(model: Model, P: Point, Q: Point) -> None:
    k = model.parameter("k", 200.0, unit="N/m")
    l0 = model.parameter("l_0", 0.8, unit="m")
    c = model.parameter("c", 3.0, unit="N s/m")
    model.spring("strut", P, Q, stiffness=k, free_length=l0, damping=c)


@_example("torque")
def _torque(model: Model, j: Body) -> None:
    model.torque("motor", on=j, value=10 - 2 * j.omega, when=j.omega > 0)


@_example("torsion spring")
def _torsion_spring(model: Model, i: Body, j: Body) -> None:
    k = model.parameter("k", 30.0, unit="N m/rad")
    c = model.parameter("c", 0.4, unit="N m s/rad")
    model.torsion_spring("coil", i, j, stiffness=k, free_angle=pi / 6, damping=c)
