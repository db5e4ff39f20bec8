"""Where clocks and watched conditions stand at a state, beside its coordinates and velocities."""

from typing import NamedTuple

from runtime.core.array_types import Matrix
from runtime.integrate.problem import Discrete


class DiscreteState(NamedTuple):
    """Samples that wait for their delay, and conditions that hold, by the names of a scene."""

    scene: str
    sampled: tuple[str, ...]  # values that clocks or conditions renew; a latch stands there twice
    clocks: Matrix  # period and delay of each of them, s, (count, 2)
    watched: tuple[tuple[str, ...], ...]  # name, action and target of each condition
    stand: Discrete
