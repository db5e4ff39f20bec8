"""The coil spring of Haug, *Computer-Aided Kinematics and Dynamics*, section 8.4.

A long spring as lumps of mass on springs, guided along x, the first of them held by the ground;
in section 8.4.2 a heavy striker runs into the last one:

     |                                                      ______
     |~~~~~[1]~~~~~[2]~~~~~[3]~~~~~[4]~~~~~[5]~~~~~[6] ←gap→ |  8   | → x
     |_____________________________________________________|______|____

The book's body 7 is the ground, body 8 the striker; x8 is measured so that the gap is x8 - x6.

Masses, stiffness and free length are those of the text; the stiffness k is 200 N/m for the surge
waves and 50, 40 and 30 N/m for the impact. Deduced rather than printed: the stiffness of the
contact, 1e6 N/m, and that the striker touches the spring at the start. Inertias do not matter,
since nothing turns.

Scenes
------
surge
    Section 8.4.1: the last mass is struck, -0.1 m/s. Figure 8.4.2. The spring alone.
impact
    Section 8.4.2: the striker arrives with -0.1 m/s. Figures 8.4.5 to 8.4.8.
impact_damped
    The same with a damper in the contact. Figure 8.4.9.
"""

from sympy import Expr

from codegen import Body, Model

FREE_LENGTH = 0.2


def machine(count: int = 6, *others: int) -> Model:
    """A spring of `count` masses and the striker, in the three scenes of the section.

    The book's has six; `load(machine(50), "surge")` runs a longer one, whose generated files have
    names of their own. With `others` the same spring may also be taken as so many masses: the
    fidelity ``"lumps"``, in the scenes `surge_{other}` and in any other that asks for it.
    """
    name = "coil_spring" if count == 6 else f"coil_spring_{count}"
    model = Model("_or_".join([name, *map(str, others)]))
    k = model.parameter("k", 50.0, unit="N/m", sign="positive")
    m = model.parameter("m", 2.5, unit="kg")
    contact_stiffness = model.parameter("contact_stiffness", 1e6, unit="N/m", sign="positive")
    contact_damping = model.parameter("contact_damping", 200.0, unit="N s/m", sign="nonnegative")

    masses = [model.body(f"mass_{i}", mass=m, inertia=1.0) for i in range(1, count + 1)]
    striker = model.body("striker", mass=100.0, inertia=1.0)
    for body in (*masses, striker):
        model.translational(f"guide_{body.name}", model.ground, body, axis=(1, 0))

    springs = []
    for i, (left, right) in enumerate(zip([model.ground, *masses], masses, strict=False), 1):
        springs.append(model.spring(f"spring_{i}", left, right, k, FREE_LENGTH))

    last = masses[-1]
    gap = striker.x - last.x
    model.contact("contact", gap=gap, stiffness=contact_stiffness)
    model.contact("damped_contact", gap=gap, stiffness=contact_stiffness, damping=contact_damping)

    at_rest = {body.x: i * FREE_LENGTH for i, body in enumerate(masses, 1)}
    arriving = {**at_rest, striker.x: count * FREE_LENGTH, striker.vx: -0.1}
    model.scene("surge", springs, without=[striker], parameters={k: 200.0},
                start={**at_rest, last.vx: -0.1})  # fmt: skip
    model.scene("impact", [*springs, "contact"], start=arriving)
    model.scene("impact_damped", [*springs, "damped_contact"], start=arriving)
    if others:
        coarse = [f"spring_{i}" for i in range(1, count + 1)]
        coarse += [f"guide_{body.name}" for body in masses] + ["contact", "damped_contact"]
        lumped = {str(other): _lumps(model, masses, other, k, m) for other in others}
        model.alternatives("lumps", {str(count): [*masses, *coarse], **lumped})
        for other in others:
            _surge(model, count, other)
    return model


def _lumps(model: Model, masses: list[Body], count: int, k: Expr, m: Expr) -> list[str]:
    """The same spring in `count` lumps: its mass, stiffness and length are those of the whole.

    Returns the names of what it is made of.
    """
    whole, part = len(masses), f"of_{count}"
    lumps = [model.body(f"lump_{i}_{part}", mass=m * whole / count, inertia=1.0)
             for i in range(1, count + 1)]  # fmt: skip
    length = FREE_LENGTH * whole / count
    guides = [model.translational(f"guide_{b.name}", model.ground, b, axis=(1, 0)) for b in lumps]
    springs = [
        model.spring(f"spring_{i}_{part}", left, right, k * count / whole, length)
        for i, (left, right) in enumerate(zip([model.ground, *lumps], lumps, strict=False), 1)
    ]
    return [element.name for element in (*lumps, *guides, *springs)]


def _surge(model: Model, whole: int, count: int) -> None:
    """The blow of the scene `surge` to the same spring in `count` lumps."""
    lumps = [model.bodies[f"lump_{i}_of_{count}"] for i in range(1, count + 1)]
    start = {body.x: i * FREE_LENGTH * whole / count for i, body in enumerate(lumps, 1)}
    start[lumps[-1].vx] = -0.1 * count / whole  # the same blow to a lighter lump
    model.scene(f"surge_{count}", extends="surge", fidelity={"lumps": str(count)}, start=start)


model = machine(6)
