"""Outputs that a scene does not name, computed from the states of a result when they are asked for.

Also the wrenches of joints in space.

The scene's companion module with all outputs evaluates the stored states, each with its modes, on
its side of an event, and with the joints that act there. Works are integrals along the steps of a
run, and no functions of states.
"""

from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.readers.arguments import number, read_arguments, row
from runtime.assembly.redundancy import suited_equations
from runtime.dynamics.connected_simulation import known_parameters
from runtime.dynamics.motion_at_instants import start_again
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.spins import matrix_g
from runtime.mechanism.table_rows import unknown
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.show.pictures import spans_of
from runtime.validation.arguments import parameter_values

_PLACE = "a place, three numbers in m, or the name of a tracked point"
_ROUNDED = 1e-9  # accuracy: of the forces of a joint; a sum of them that is none
_AT = row(_PLACE, *[number(_PLACE, unit="m")] * 3)


def outputs_afterwards(result: Result) -> list[tuple[slice, Description, Samples]]:
    """Rows of the result, and all outputs in them with their tables: a part a set of joints."""
    mechanism, there = _machine_of(result), result.description
    found, times, parts = [], result.instants_of_states, spans_of(result, mechanism)
    acting = {known.description.scene for known, _ in parts}
    others = [one for scene, one in mechanism.siblings.items() if scene not in acting]
    for known, rows in [*parts, *((one, slice(0)) for one in others)]:
        whole = known.with_all_outputs
        here, states = whole.description, result.samples.at(rows)
        places = {name: k for k, name in enumerate(there.coordinates.names)}
        columns = [places[name] for name in here.coordinates.names]
        q, v = (np.ascontiguousarray(x[:, columns]) for x in (states.q, states.v))
        switches = {row: k for k, row in enumerate(there.switches)}
        modes = states.modes[:, [switches[row] for row in here.switches]]
        p = parameter_values(whole, known_parameters(whole, result.parameters))
        equations = Equations(whole, p)
        if len(q) and np.isfinite(v[0]).all():  # else it is locked, and nothing is a number
            begin = start_again(whole, p, float(times[rows][0]), q[0], v[0])
            equations = suited_equations(equations, begin)
        found.append((rows, here, evaluate(equations, times[rows], q, v, modes)))
    return found


def _machine_of(result: Result) -> Mechanism:
    if result._mechanism is None:
        title = result.description.title
        raise InputError(f"{title}: the machine of this result is not known; load it.")
    return result._mechanism


def joint_wrench(result: Result, joint: str, on: str, at: Any, axes: str) -> FloatArray:
    """See `Result.wrench`. A joint exerts F = -Φ_rᵀ λ and n' = -½ G Φ_pᵀ λ on a body at its centre.

    The ground bears the opposite of what acts on all bodies.
    """
    mechanism, q, lam = _machine_of(result), result.samples.q, result.samples.lam
    p = parameter_values(mechanism, known_parameters(mechanism, result.parameters))
    equations = Equations(mechanism, p).whole
    about, times = equations.description, result.instants_of_states.tolist()
    bodies, names = dict(about.turning), about.coordinates.names
    turned = {name: result.rotation(name) for name in {*bodies, on, axes} - {"ground"}}
    turned["ground"] = np.tile(np.eye(3), (len(q), 1, 1))
    joints = [one.element if one.element not in bodies else "" for one in about.constraints]
    if not bodies or joint not in {*joints} - {""}:
        known = dict.fromkeys(filter(None, joints if bodies else ()))
        raise InputError(f"{about.title}: {unknown('joint or driver in space', joint, known)}")
    if not about.has_masses:
        raise InputError(about.need_masses(f"wrench({joint})"))
    counting = [k for k, row in enumerate(about.constraints) if row.name in names]  # own rows
    rows = [k for k, name in enumerate(joints) if name == joint and k not in counting]
    if np.isnan(lam[:, rows]).all():  # no output of the scene asks for them
        lam = result._afterwards[0][-1].lam
    forces = np.zeros_like(q)
    for k, t in enumerate(times):
        forces[k] = -lam[k, rows] @ equations.jacobian(t, q[k])[rows]
    columns = about.jacobian_columns[np.isin(about.jacobian_rows, rows)]
    owners = {names[k].rpartition(".")[0] for k in columns}
    acting = [body for body in bodies if body in owners]
    where = ", ".join(acting) or "coordinates of joints, and its reaction says how"
    elsewhere = f"{about.title}: '{joint}' acts on {where}, not on '{on}'."
    if on not in ("ground", *acting):
        raise InputError(elsewhere)
    places = {body: q[:, k : k + 3] for body in acting for k in [names.index(f"{body}.x")]}
    places["ground"] = force = torque = sizes = np.zeros((len(q), 3))
    for body in acting if on == "ground" else (on,):
        x, e = names.index(f"{body}.x"), bodies[body]
        own, g = forces[:, x : x + 3], matrix_g(q[:, e : e + 4])
        couple = (turned[body] @ (0.5 * g @ forces[:, e : e + 4, None]))[..., 0]
        couple = couple + np.cross(places[body] - places[on], own)
        force, torque = force + own, torque + couple
        sizes = np.maximum(sizes, np.maximum(np.abs(own), np.abs(couple)))
    cancels = np.abs([force, torque]).max() < _ROUNDED * sizes.max()
    if on == "ground" and (cancels or not acting):
        raise InputError(elsewhere)  # what it exerts on one body it exerts back on another
    if isinstance(at, str):
        arm = result.point(at) - places[on]
    else:
        given = {"at": at.tolist() if isinstance(at, np.ndarray) else at}
        arm = turned[on] @ np.array(read_arguments("wrench", {"at": _AT}, given)["at"])
    wrench = np.stack([force, torque - np.cross(arm, force)], axis=1) @ turned[axes]
    return np.asarray(wrench.reshape(-1, 6) * (-1.0 if on == "ground" else 1.0))
