"""Refusal of analyses for which a scene was compiled without the equations."""

from typing import NoReturn

from codegen.errors import AnalysisError
from runtime.mechanism.mechanism import Mechanism
from runtime.results.assembled_state import Assembly


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
