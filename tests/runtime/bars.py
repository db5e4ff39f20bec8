"""Bars on revolute joints, of any number, with kernels that loop over the joints.

They are the machines of `benchmarks.chain` and `models.hard.n_four_bar`, without a build: uniform
bars of 1 m and 1 kg under gravity. The matrices Φ_q W Φ_qᵀ are banded in the order of the joints,
so that each kernel takes a time that is linear in the number of bars.
"""

from functools import cache
from math import pi
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numba import njit

from runtime.core.kernel_abi import SIGNATURES, gather
from runtime.machine_facade import Machine
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import describe

OPTIONS = {"error_model": "numpy"}
INERTIA = 1.0 / 12.0
WEAK = 1e-9


class Hinge(NamedTuple):
    """A revolute joint: the bars that it joins, -1 the ground, and its place on each, m."""

    name: str
    first: int
    at_first: float
    second: int
    at_second: float


@cache
def chain(links: int) -> Machine:
    """A chain of bars, level and at rest."""
    hinges = [Hinge(f"hinge_{k}", k - 1, 0.5 if k else 0.0, k, -0.5) for k in range(links)]
    start = {}
    for k in range(links):
        start |= {f"link_{k}.phi": (0.0, "fixed"), f"link_{k}.omega": (0.0, "fixed")}
        start |= {f"link_{k}.x": (k + 0.5, "guess"), f"link_{k}.y": (0.0, "guess")}
    return machine(f"chain_{links}", [f"link_{k}" for k in range(links)], hinges, start)


@cache
def n_four_bar(loops: int) -> Machine:
    """Square loops in a row, upright, the upper joints at 1 m/s."""
    bars, hinges = ["crank_0"], [Hinge("A0", -1, 0.0, 0, -0.5)]
    start = {"crank_0.phi": (pi / 2, "fixed"), "crank_0.omega": (-1.0, "fixed")}
    for k in range(1, loops + 1):
        coupler, crank, before = 2 * k - 1, 2 * k, max(2 * k - 2, 0)
        bars += [f"coupler_{k}", f"crank_{k}"]
        hinges.append(Hinge(f"B{k - 1}", before, 0.5, coupler, -0.5))
        hinges.append(Hinge(f"C{k}", crank, 0.5, coupler, 0.5))
        hinges.append(Hinge(f"A{k}", -1, float(k), crank, -0.5))
        start |= {f"crank_{k}.phi": (pi / 2, "guess"), f"crank_{k}.omega": (-1.0, "guess")}
        start |= {f"coupler_{k}.x": (k - 0.5, "guess"), f"coupler_{k}.y": (1.0, "guess")}
        start |= {f"coupler_{k}.vx": (1.0, "guess")}
    for k in range(loops + 1):
        start |= {f"crank_{k}.x": (float(k), "guess"), f"crank_{k}.y": (0.5, "guess")}
        start |= {f"crank_{k}.vx": (0.5, "guess")}
    return machine(f"n_four_bar_{loops}", bars, hinges, start)


def machine(
    name: str, bars: list[str], hinges: list[Hinge], start: dict[str, tuple[float, str]]
) -> Machine:
    """The machine of these bars and joints, from values and roles of its start."""
    rows, columns = pattern(hinges)
    module = ModuleType(name)
    tables = {
        "generator": "tests",
        "model": name,
        "scene": "fall",
        "formulation": "cartesian",
        "analysis": "dynamics",
        "sources": (),
        "bodies": tuple(bars),
        "coordinates": tuple(
            (f"{bar}.{q}", f"{bar}.{v}", unit)
            for bar in bars
            for q, v, unit in (("x", "vx", "m"), ("y", "vy", "m"), ("phi", "omega", "rad"))
        ),
        "constraints": tuple((h.name, "revolute", axis) for h in hinges for axis in "xy"),
        "constants": (),
        "effects": (("gravity", "gravity"),),
        "drivers": (),
        "start": tuple((name, value, role) for name, (value, role) in start.items()),
        "jacobian_rows": rows,
        "jacobian_columns": columns,
        "mass_rows": np.arange(3 * len(bars)),
        "mass_columns": np.arange(3 * len(bars)),
        "operations": (),
        "weak_pivot": WEAK,
    }
    for word, value in tables.items():
        setattr(module, word.upper(), value)
    for word, kernel in kernels_of(len(bars), hinges, rows, columns).items():
        setattr(module, word, kernel)
    return Machine(Mechanism(describe(module), gather(module), Path(f"{name}.py"), None))


def pattern(hinges: list[Hinge]) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the structural non-zeros of Φ_q, row after row."""
    places = []
    for k, hinge in enumerate(hinges):
        for axis in range(2):
            bars = sorted(bar for bar in (hinge.first, hinge.second) if bar >= 0)
            for bar in bars:
                places += [(2 * k + axis, 3 * bar + axis), (2 * k + axis, 3 * bar + 2)]
    rows, columns = np.array(places, np.int64).T
    return np.ascontiguousarray(rows), np.ascontiguousarray(columns)


def kernels_of(bars: int, hinges: list[Hinge], rows: np.ndarray, columns: np.ndarray) -> dict:
    """The kernels of these joints by name."""
    n, m, count, nonzeros = 3 * bars, 2 * len(hinges), len(hinges), len(rows)
    first, second = (np.array([h[k] for h in hinges], np.int64) for k in (1, 3))
    at_first, at_second = (np.array([h[k] for h in hinges]) for k in (2, 4))
    # Of each non-zero: the bar, its sign in the constraint, its place along the bar.
    joint, angular = rows // 2, columns % 3 == 2
    bar = columns // 3
    of_first = bar == first[joint]
    sign = np.where(of_first, 1.0, -1.0)
    along = np.where(of_first, at_first[joint], at_second[joint])
    rows_of_column = np.full((n, 8), -1)
    for e, j in enumerate(columns):
        rows_of_column[j, np.argmax(rows_of_column[j] < 0)] = e
    width = 1 + max(
        int(rows[e] - rows[f])
        for found in rows_of_column
        for e in found[found >= 0]
        for f in found[found >= 0]
    )

    @njit(SIGNATURES["constraints"], **OPTIONS)
    def constraints(t, q, p, phi):
        for k in range(count):
            x, y = 0.0, 0.0
            for end in range(2):
                b, at, s = first[k], at_first[k], 1.0
                if end == 1:
                    b, at, s = second[k], at_second[k], -1.0
                if b < 0:
                    x += s * at
                else:
                    x += s * (q[3 * b] + at * np.cos(q[3 * b + 2]))
                    y += s * (q[3 * b + 1] + at * np.sin(q[3 * b + 2]))
            phi[2 * k], phi[2 * k + 1] = x, y

    @njit(SIGNATURES["jacobian"], **OPTIONS)
    def jacobian(t, q, p, values):
        for e in range(nonzeros):
            values[e] = sign[e]
            if angular[e]:
                phi = q[columns[e]]
                slope = np.cos(phi) if rows[e] % 2 else -np.sin(phi)
                values[e] = sign[e] * along[e] * slope

    @njit(SIGNATURES["velocity_rhs"], **OPTIONS)
    def velocity_rhs(t, q, p, nu):
        nu[:] = 0.0

    @njit(SIGNATURES["acceleration_rhs"], **OPTIONS)
    def acceleration_rhs(t, q, v, p, gamma):
        gamma[:] = 0.0
        for e in range(nonzeros):
            if angular[e]:
                phi, omega = q[columns[e]], v[columns[e]]
                unit = np.sin(phi) if rows[e] % 2 else np.cos(phi)
                gamma[rows[e]] += sign[e] * along[e] * unit * omega * omega

    @njit(SIGNATURES["mass"], **OPTIONS)
    def mass(q, p, values):
        for j in range(n):
            values[j] = INERTIA if j % 3 == 2 else 1.0

    @njit(SIGNATURES["applied_forces"], **OPTIONS)
    def applied_forces(t, q, v, p, modes, force):
        for j in range(n):
            force[j] = -9.81 if j % 3 == 1 else 0.0

    @njit
    def factor(values, w, band):
        """L D Lᵀ = Φ_q W Φ_qᵀ, by diagonals; 0, or 1 + a row whose pivot is weak."""
        band[:, :] = 0.0
        for j in range(n):
            for a in range(8):
                e = rows_of_column[j, a]
                if e < 0:
                    break
                for b in range(8):
                    f = rows_of_column[j, b]
                    if f < 0:
                        break
                    if rows[e] >= rows[f]:
                        band[rows[e], rows[e] - rows[f]] += values[e] * w[j] * values[f]
        weak = 0
        for i in range(m):
            whole = band[i, 0]
            for d in range(min(width - 1, i), -1, -1):
                k = i - d
                total = band[i, d]
                for c in range(max(0, i - width + 1), k):
                    if k - c < width:
                        total -= band[i, i - c] * band[c, 0] * band[k, k - c]
                band[i, d] = total if d == 0 else total / band[k, 0]
            if not abs(band[i, 0]) > WEAK * whole:
                weak = i + 1
        return weak

    @njit
    def solve(band, x):
        for i in range(m):
            for d in range(1, min(width - 1, i) + 1):
                x[i] -= band[i, d] * x[i - d]
        for i in range(m):
            x[i] /= band[i, 0]
        for i in range(m - 1, -1, -1):
            for d in range(1, min(width - 1, i) + 1):
                x[i - d] -= band[i, d] * x[i]

    @njit(SIGNATURES["accelerations"], **OPTIONS)
    def accelerations(t, q, v, p, modes, a, lam):
        values, w, band = np.empty(nonzeros), np.empty(n), np.empty((m, width))
        jacobian(t, q, p, values)
        applied_forces(t, q, v, p, modes, a)
        acceleration_rhs(t, q, v, p, lam)
        for j in range(n):
            w[j] = 1.0 / INERTIA if j % 3 == 2 else 1.0
            a[j] *= w[j]
        weak = factor(values, w, band)
        for i in range(m):
            lam[i] = -lam[i]
        for e in range(nonzeros):
            lam[rows[e]] += values[e] * a[columns[e]]
        solve(band, lam)
        for e in range(nonzeros):
            a[columns[e]] -= w[columns[e]] * values[e] * lam[rows[e]]
        return weak

    @njit(SIGNATURES["correction"], **OPTIONS)
    def correction(t, q, v, p, w, dq, dv):
        values, band = np.empty(nonzeros), np.empty((m, width))
        gap, rate = np.empty(m), np.zeros(m)
        jacobian(t, q, p, values)
        weak = factor(values, w, band)
        constraints(t, q, p, gap)
        for i in range(m):
            gap[i] = -gap[i]
        for e in range(nonzeros):
            rate[rows[e]] -= values[e] * v[columns[e]]
        solve(band, gap)
        solve(band, rate)
        dq[:] = 0.0
        dv[:] = 0.0
        for e in range(nonzeros):
            dq[columns[e]] += w[columns[e]] * values[e] * gap[rows[e]]
            dv[columns[e]] += w[columns[e]] * values[e] * rate[rows[e]]
        return weak

    @njit(SIGNATURES["potential"], **OPTIONS)
    def potential(t, q, p, modes):
        return 9.81 * q[1::3].sum()

    @njit(SIGNATURES["potential_gradient"], **OPTIONS)
    def potential_gradient(t, q, p, modes, gradient):
        for j in range(n):
            gradient[j] = 9.81 if j % 3 == 1 else 0.0

    @njit(SIGNATURES["kinetic_energy"], **OPTIONS)
    def kinetic_energy(q, v, p):
        total = 0.0
        for j in range(n):
            total += 0.5 * (INERTIA if j % 3 == 2 else 1.0) * v[j] * v[j]
        return total

    found = locals()
    return {name: found[name] for name in SIGNATURES if name in found}
