"""Generalized forces Q by the formulas of Haug's section 6.1, written out by hand.

q = (x_i, y_i, φ_i, x_j, y_j, φ_j). Points, axis and names are those of `benchmarks.hand.joints`;
a tension f along d pulls with f d / ℓ on i and its opposite on j, and a point's force F turns its
body by a × F. All of Q is written, as a kernel must that is asked for all of it.
"""

import math

from sympy import cos, sin, sqrt

from benchmarks.element_sample import Sample
from benchmarks.element_sample import force as sample
from benchmarks.hand.signatures import force, small, solution
from codegen import Model
from codegen import t as time
from codegen.declare.body import Point

SIX, SIY, SJX, SJY = 0.3, -0.2, -0.5, 0.1
UX, UY = 0.6, 0.8
MASS_I, MASS_J = 2.0, 3.0


@small
def rotated(phi, x, y):
    """A (x, y)."""
    c, s = math.cos(phi), math.sin(phi)
    return c * x - s * y, s * x + c * y


@force
def gravity(t, q, v, p, modes, Q):
    Q[0] = 0.0
    Q[1] = -9.81 * MASS_I
    Q[2] = 0.0
    Q[3] = 0.0
    Q[4] = -9.81 * MASS_J
    Q[5] = 0.0


@force
def applied(t, q, v, p, modes, Q):
    """F = (4, -7) N: what its moment is at φ = 0 and at φ = -π/2 is known before."""
    at_0, at_minus_90 = SJX * -7.0 - SJY * 4.0, SJY * -7.0 + SJX * 4.0
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = 4.0
    Q[4] = -7.0
    Q[5] = at_0 * math.cos(q[5]) - at_minus_90 * math.sin(q[5])


@force
def following(t, q, v, p, modes, Q):
    """A force fixed in the body: its moment s'_x F'_y - s'_y F'_x is constant."""
    fx, fy = rotated(q[5], 4.0, -7.0)
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = fx
    Q[4] = fy
    Q[5] = SJX * -7.0 - SJY * 4.0


@force
def torque(t, q, v, p, modes, Q):
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = 20.0 - 3.0 * v[5]


@force
def spring(t, q, v, p, modes, Q):
    """f = 120 (ℓ - 0.8) + 9 ℓ̇ + 5."""
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    dx, dy = q[3] + jx - q[0] - ix, q[4] + jy - q[1] - iy
    vx, vy = v[3] - wj * jy - v[0] + wi * iy, v[4] + wj * jx - v[1] - wi * ix
    length = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / length
    pull = 120.0 * (length - 0.8) + 9.0 * (inverse * (dx * vx + dy * vy)) + 5.0
    pull *= inverse
    fx, fy = pull * dx, pull * dy
    Q[0] = fx
    Q[1] = fy
    Q[2] = ix * fy - iy * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy


@force
def line_force(t, q, v, p, modes, Q):
    """f = 40 ℓ + 3."""
    ix, iy = rotated(q[2], SIX, SIY)
    jx, jy = rotated(q[5], SJX, SJY)
    dx, dy = q[3] + jx - q[0] - ix, q[4] + jy - q[1] - iy
    length = math.sqrt(dx * dx + dy * dy)
    pull = (40.0 * length + 3.0) / length
    fx, fy = pull * dx, pull * dy
    Q[0] = fx
    Q[1] = fy
    Q[2] = ix * fy - iy * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy


@force
def motor(t, q, v, p, modes, Q):
    """T = 0.8 (0.5 - ω/300)."""
    n = 0.8 * (0.5 - (v[5] - v[2]) / 300.0)
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = -n
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = n


@force
def torsion_spring(t, q, v, p, modes, Q):
    """n = 12 (θ - 0.2) + 0.6 θ̇ + 1.5."""
    n = 12.0 * (q[5] - q[2] - 0.2) + 0.6 * (v[5] - v[2]) + 1.5
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = n
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = -n


@force
def rigid_contact(t, q, v, p, modes, Q):
    """A unit of force, the weight of both bodies, along u in body i while the gap is closed."""
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    ex, ey = q[3] + jx - q[0], q[4] + jy - q[1]
    f = 0.0 if modes[0] else -9.81 * (MASS_I + MASS_J)
    fx, fy = f * ux, f * uy
    Q[0] = fx
    Q[1] = fy
    Q[2] = ex * fy - ey * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy


@force
def dry_friction(t, q, v, p, modes, Q):
    """f = -0.4 · 30 N along x, against the slip of the points."""
    f = -12.0 if modes[0] else 12.0
    iy = rotated(q[2], SIX, SIY)[1]
    jy = rotated(q[5], SJX, SJY)[1]
    Q[0] = -f
    Q[1] = 0.0
    Q[2] = iy * f
    Q[3] = f
    Q[4] = 0.0
    Q[5] = -jy * f


@force
def bushing(t, q, v, p, modes, Q):
    """k = (900, 700, 50), c = (8, 6, 0.4), θ0 = 0.1."""
    c, s = math.cos(q[2]), math.sin(q[2])
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    ex, ey = q[3] + jx - q[0], q[4] + jy - q[1]
    vx, vy = v[3] - wj * jy - v[0] + wi * ey, v[4] + wj * jx - v[1] - wi * ex
    fx = 900.0 * (c * ex + s * ey - SIX) + 8.0 * (c * vx + s * vy)
    fy = 700.0 * (c * ey - s * ex - SIY) + 6.0 * (c * vy - s * vx)
    n = 50.0 * (q[5] - q[2] - 0.1) + 0.4 * (wj - wi)
    fx, fy = c * fx - s * fy, s * fx + c * fy
    Q[0] = fx
    Q[1] = fy
    Q[2] = n + ex * fy - ey * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy - n


@force
def contact(t, q, v, p, modes, Q):
    """f = 5000 g + 30 ġ while g = u'd - 0.1 is negative."""
    closed = modes[0]
    ux, uy = rotated(q[2], UX, UY)
    jx, jy = rotated(q[5], SJX, SJY)
    wi, wj = v[2], v[5]
    ex, ey = q[3] + jx - q[0], q[4] + jy - q[1]
    vx, vy = v[3] - wj * jy - v[0] + wi * ey, v[4] + wj * jx - v[1] - wi * ex
    if closed:
        gap = ux * ex + uy * ey - (UX * SIX + UY * SIY + 0.1)
        f = 5000.0 * gap + 30.0 * (ux * vx + uy * vy)
    else:
        f = 0.0
    fx, fy = f * ux, f * uy
    Q[0] = fx
    Q[1] = fy
    Q[2] = ex * fy - ey * fx
    Q[3] = -fx
    Q[4] = -fy
    Q[5] = jy * fx - jx * fy


@force
def potential(t, q, v, p, modes, Q):
    """A user's own: V = 6 (x_i² + y_i²)²."""
    pull = -24.0 * (q[0] * q[0] + q[1] * q[1])
    Q[0] = pull * q[0]
    Q[1] = pull * q[1]
    Q[2] = 0.0
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = 0.0


@force
def generalized(t, q, v, p, modes, Q):
    """A user's own: a drag -3 ẋ_i √(ẋ_i² + 0.01)."""
    Q[0] = -3.0 * v[0] * math.sqrt(v[0] * v[0] + 0.01)
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = 0.0


@force
def mass_flow(t, q, v, p, modes, Q):
    """Matter comes to a particle, the third body, with the velocity (1, -3) m/s."""
    Q[0] = 0.0
    Q[1] = 0.0
    Q[2] = 0.0
    Q[3] = 0.0
    Q[4] = 0.0
    Q[5] = 0.0
    Q[6] = v[8] * (1.0 - v[6])
    Q[7] = v[8] * (-3.0 - v[7])
    Q[8] = 0.0


@solution
def friction(t, q, v, p, modes, a, lam):
    """Body i slides on a level guide, pressed by its weight: ẍ_i = 6 - μ g tanh(ẋ_i / v_c).

    The guide's multipliers are -m g and no couple.
    """
    a[0] = 6.0 - 0.3 * 9.81 * math.tanh(100.0 * v[0])
    a[1] = 0.0
    a[2] = 0.0
    lam[0] = -9.81 * MASS_I
    lam[1] = 0.0
    return 0


# -- the samples that are measured, beside their twins ------------------------------------------


def _rubbing(m: Model, i: Point, j: Point) -> None:
    guide = m.translational("guide", m.ground, i.body)
    m.force("push", on=i.body, fx=12)
    m.gravity("weight", (0, -9.81))
    m.friction("e", guide, 0.3, 0.01)


def _sticking(m: Model, i: Point, j: Point) -> None:
    speeds = [
        b.vx - b.omega * (sin(b.phi) * x + cos(b.phi) * y)
        for b, (x, y) in ((i.body, (SIX, SIY)), (j.body, (SJX, SJY)))
    ]
    m.dry_friction("e", slip=speeds[1] - speeds[0], normal=30.0, coefficient=0.4)


def _drag(m: Model, i: Point, j: Point) -> None:
    vx = i.body.vx
    m.generalized_force("e", {i.body.x: -3 * vx * sqrt(vx**2 + 0.01)})


def _filling(m: Model, i: Point, j: Point) -> None:
    m.mass_flow("e", m.particle("tank", mass=5 + 2 * time), velocity=(1, -3))


SAMPLES = (
    sample("gravity", lambda m, i, j: m.gravity("e", (0, -9.81)), gravity),
    sample("force", lambda m, i, j: m.force("e", j, 4, -7), applied),
    sample(
        "force",
        lambda m, i, j: m.force("e", j, 4, -7, frame="body"),
        following,
        "force fixed in the body",
    ),
    sample("torque", lambda m, i, j: m.torque("e", j.body, 20 - 3 * j.body.omega), torque),
    sample("spring", lambda m, i, j: m.spring("e", i, j, 120, 0.8, 9, 5), spring),
    sample(
        "line force",
        lambda m, i, j: m.line_force("e", i, j, lambda length, rate: 40 * length + 3),
        line_force,
    ),
    sample(
        "motor",
        lambda m, i, j: m.motor(
            "e", j.body, i.body, stall_torque=0.8, no_load_speed=300, voltage=0.5
        ),
        motor,
    ),
    sample(
        "torsion spring",
        lambda m, i, j: m.torsion_spring("e", i.body, j.body, 12, 0.2, 0.6, 1.5),
        torsion_spring,
    ),
    sample(
        "bushing", lambda m, i, j: m.bushing("e", i, j, (900, 700, 50), (8, 6, 0.4), 0.1), bushing
    ),
    sample(
        "contact",
        lambda m, i, j: m.contact(
            "e", i, j, stiffness=5000, damping=30, free_length=0.1, direction=(UX, UY)
        ),
        contact,
    ),
    sample(
        "potential",
        lambda m, i, j: m.potential("e", 6 * (i.body.x**2 + i.body.y**2) ** 2),
        potential,
        "potential, 6 r⁴",
    ),
    sample("dry friction", _sticking, dry_friction, "dry friction"),
    sample(
        "rigid contact",
        lambda m, i, j: m.contact("e", i, j, direction=(UX, UY), free_length=0.1, restitution=0.5),
        rigid_contact,
        "rigid contact",
    ),
    sample("generalized force", _drag, generalized, "generalized force, drag"),
    sample("mass flow", _filling, mass_flow),
    Sample("friction", "friction in a guide", _rubbing, {"accelerations": friction}),
)
