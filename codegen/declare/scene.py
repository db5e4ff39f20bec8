"""A scene: which bodies, effects and drivers of a machine take part in a question asked of it."""

from dataclasses import dataclass
from typing import Literal

Analysis = Literal["dynamics", "kinematics"]


@dataclass(frozen=True)
class Scene:
    """What is compiled together; everything by name.

    Attributes
    ----------
    name
        An identifier.
    bodies
        The bodies that take part, in the order of their declaration.
    effects, drivers
        What acts; joints act where all their bodies take part.
    opened
        Joints that do not act although their bodies take part.
    start
        Coordinate or velocity (``"crank.phi"``, ``"crank.omega"``) → value that must hold.
    guess
        The same → value from which assembly starts.
    parameters
        Parameter → value in this scene instead of the declared one.
    frozen
        Whether the parameters are folded into the code as numbers.
    analysis
        ``"kinematics"`` compiles no mass and no force.
    """

    name: str
    bodies: tuple[str, ...]
    effects: tuple[str, ...]
    drivers: tuple[str, ...]
    opened: tuple[str, ...]
    start: tuple[tuple[str, float], ...]
    guess: tuple[tuple[str, float], ...]
    parameters: tuple[tuple[str, float], ...]
    frozen: bool
    analysis: Analysis
