"""Questions that a scene was compiled without the means to answer."""

from typing import NoReturn

from codegen.errors import AnalysisError
from runtime.mechanism.mechanism import Mechanism


def require_motion(mechanism: Mechanism, question: str) -> None:
    """Refuse a motion where the scene asks only where the machine rests.

    Raises
    ------
    AnalysisError
        If its kernels of motion were left out.
    """
    told = mechanism.description
    if told.analysis == "equilibrium":
        raise AnalysisError(
            f"{told.title}: {question} needs the equations of motion, which a scene with "
            f"analysis='equilibrium' leaves out. Declare it with analysis='dynamics', or load "
            f"scene.with_(analysis='dynamics')."
        )


def require_energy(mechanism: Mechanism) -> None:
    """Refuse a search for equilibrium where the potential was left out.

    Raises
    ------
    AnalysisError
        If the scene has masses and no kernel of the potential.
    """
    told = mechanism.description
    if told.has_masses and "potential" not in told.kernels:
        raise AnalysisError(f"equilibrium needs the potential energy: {told.offer('energy')}")


def refuse_structure(mechanism: Mechanism) -> None:
    """Refuse to integrate where joints hold all and no driver moves anything.

    Raises
    ------
    AnalysisError
        If the scene has no driver.
    """
    told = mechanism.description
    if not told.drivers:
        raise AnalysisError(
            f"{told.title}: nothing is left to integrate: {len(told.constraints)} constraints hold "
            f"all {len(told.coordinates)} coordinates and no driver moves them. Leave a joint out, "
            f"take a driver in, or ask for inverse_dynamics, which gives the reactions at rest."
        )


def refuse_massless(mechanism: Mechanism) -> NoReturn:
    """Refuse a simulation where no mass moves.

    Raises
    ------
    AnalysisError
        With what to ask for instead.
    """
    told = mechanism.description
    if told.analysis == "kinematics":
        raise AnalysisError(
            f"{told.title}: a simulation needs masses and forces, which a scene with "
            f"analysis='kinematics' leaves out, so there is nothing to integrate. Ask for "
            f"kinematics, or load scene.with_(analysis='dynamics')."
        )
    raise AnalysisError(
        f"{told.title}: a simulation needs masses, and this scene has a body without. Give "
        f"every body a mass and an inertia, or ask for kinematics."
    )


def carried(mechanism: Mechanism, freedom: int) -> str:
    """What a simulation says where drivers leave nothing to integrate; else nothing."""
    told = mechanism.description
    if freedom or not told.drivers:
        return ""
    return (
        f" Nothing was left to integrate: with drivers {', '.join(told.drivers)} the "
        f"{len(told.constraints)} constraints determine all {len(told.coordinates)} coordinates. "
        f"inverse_dynamics gives the same motion and forces at any instants without steps, "
        f"kinematics the motion alone."
    )
