"""Refusal of analyses for which a scene lacks equations, or has set-valued contacts or friction."""

from typing import NoReturn

import numpy as np

from codegen.errors import AnalysisError, InputError, ParameterError
from runtime.core.arrays import Matrix, Vector
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly

MASSES = ("kg", "kg m^2")  # units of the coordinates that are masses


def require_motion(mechanism: Mechanism, question: str) -> None:
    """Refuse an analysis of motion for a scene that was declared for equilibrium."""
    description = mechanism.description
    if description.analysis == "equilibrium":
        raise AnalysisError(
            f"{description.title}: {question} needs the equations of motion, which a scene with "
            f"analysis='equilibrium' leaves out. Declare it with analysis='dynamics', or load "
            f"scene.with_(analysis='dynamics')."
        )


def refuse_states(mechanism: Mechanism, question: str) -> None:
    """Refuse an analysis of positions where states follow from their rates and samples alone."""
    description = mechanism.description
    if description.states:
        names = description.states.names
        raise AnalysisError(
            f"{description.title}: {question} knows positions, but {', '.join(names)} follow from "
            f"their rates and samples, which only a simulation does. Ask for simulate, which gives "
            "a driven motion with its forces as well, or load "
            f"scene.without({', '.join(map(repr, names))}) with the effects that contain them."
        )


def require_plane(mechanism: Mechanism, question: str, advice: str) -> None:
    """Refuse a question in space that only machines in the plane answer so far."""
    if mechanism.description.turning:
        raise AnalysisError(
            f"{mechanism.description.title}: {question} there for machines in the plane alone so "
            f"far. {advice}"
        )


def require_energy(mechanism: Mechanism) -> None:
    """Refuse a search for equilibrium where the potential was left out."""
    description = mechanism.description
    if description.has_masses and "potential" not in description.kernels:
        raise AnalysisError(
            f"equilibrium needs the potential energy: {description.suggest_output('energy')}"
        )


def refuse_structure(mechanism: Mechanism) -> None:
    """Refuse to integrate where the joints determine all coordinates and no driver moves them."""
    description = mechanism.description
    if not description.drivers:
        raise AnalysisError(
            f"{description.title}: nothing is left to integrate: {len(description.constraints)} "
            f"constraints hold all {len(description.positions)} coordinates and no driver moves "
            "them. Leave a joint out, take a driver in, or ask for inverse_dynamics, which gives "
            "the reactions at rest."
        )


def refuse_massless(mechanism: Mechanism) -> NoReturn:
    """Refuse a simulation where no mass moves."""
    description = mechanism.description
    if description.analysis == "kinematics":
        raise AnalysisError(
            f"{description.title}: a simulation needs masses and forces, which a scene with "
            f"analysis='kinematics' leaves out, so there is nothing to integrate. Ask for "
            f"kinematics, or load scene.with_(analysis='dynamics')."
        )
    raise AnalysisError(description.need_masses("a simulation", ", or ask for kinematics"))


def driven_note(mechanism: Mechanism, begin: Assembly) -> str:
    """Sentence of a simulation whose drivers determine the motion; else empty."""
    description = mechanism.description
    if not begin.is_determined or not description.drivers:
        return ""
    return (
        f" Nothing was left to integrate: with drivers {', '.join(description.drivers)} the "
        f"{len(description.constraints)} constraints determine all {len(description.positions)} "
        "coordinates. inverse_dynamics gives the same motion and forces at any instants without "
        f"steps, kinematics the motion alone."
    )


def require_mass(description: Description, t: Vector, q: Matrix) -> None:
    """Refuse positions q, (k, n), at instants t, (k,), in which a mass that varies is lost."""
    problems = [
        f"{description.title}: {row.name} is {q[first, k]:g} {row.unit} at t = {t[first]:.9g} s; "
        "it must be positive. Give another law or start, or end before this time."
        for k, row in enumerate(description.coordinates)
        for first in (np.flatnonzero(q[:, k] <= 0.0)[:1] if row.unit in MASSES else ())
    ]
    if problems:
        raise ParameterError(problems)


def require_apart(
    mechanism: Mechanism, p: Vector, t: float, q: Vector, v: Vector, size: float
) -> None:
    """Refuse an assembled start in which bodies overlap at a rigid contact; `size` is in m."""
    description = mechanism.description
    if not description.rigid:
        return
    from runtime.hybrid.mode_selection import TOUCHING  # compiles where it is used

    g = np.zeros(len(description.switches))
    mechanism.kernels.switching(t, q, v, p, g)
    problems = [
        f"{description.title}: at t = {t:g} s the gap of '{contact.name}' is "
        f"{g[contact.switch]:.6g} in SI units: bodies overlap at a rigid contact, or a coordinate "
        "lies beyond a rigid stop. Start where the gap is zero or positive."
        for contact in description.rigid
        if not g[contact.switch] >= -TOUCHING * size
    ]
    if problems:
        raise InputError(problems)


def require_no_rigid(mechanism: Mechanism, analysis: str) -> None:
    """Refuse an analysis that determines neither contacts, freewheels nor joints that change."""
    description = mechanism.description
    joints = dict.fromkeys(row.target for row in description.watched if row.reconnects)
    if joints and analysis != "equilibrium":
        raise AnalysisError(
            f"{mechanism.title}: {analysis} cannot release or engage {', '.join(joints)}; simulate."
        )
    if wheels := [row.name for row in description.switches if row.one_way]:
        raise AnalysisError(
            f"{description.title}: {analysis} does not decide which one-way clutches grip, and "
            f"this scene has {', '.join(wheels)}. Let the machine come to rest in a simulation, or "
            "ask for a scene without them: with a gear where a clutch grips, or with capacity=."
        )
    if description.rigid:
        raise AnalysisError(
            f"{description.title}: {analysis} does not decide which rigid contacts or stops are "
            f"closed, and this scene has {', '.join(description.rigid.names)}. Let the machine "
            "come to rest in a simulation, or ask for a scene without them: with a joint where a "
            "contact is closed, or with stiffness= in place of restitution=."
        )


def require_no_sticking(mechanism: Mechanism, analysis: str) -> None:
    """Refuse a search for equilibrium with sticking friction, which has no single answer."""
    description = mechanism.description
    names = dict.fromkeys(row.name for row in description.switches if row.sticks)
    if names:
        raise AnalysisError(
            f"{description.title}: {analysis} has no single answer, since the friction in "
            f"{', '.join(names)} sticks: the machine rests wherever the forces stay within it. "
            "Simulate to see where it comes to rest, or ask for a scene without the friction."
        )
