"""Random mechanisms for the tests: sound ones by construction, the same for a seed.

`random_mechanism(seed)` draws sizes and poses first; joints follow from the poses, so that
every mechanism is assembled at t = 0. Its `model()` is a declaration with the scene ``"run"``.
Modules named `spatial_…` hold the same for bodies in space.
"""

from tests.random_mechanisms.generator import (
    DRIVEN,
    FAMILIES,
    FRICTION,
    PLAIN,
    RandomMechanism,
    random_mechanism,
)
from tests.random_mechanisms.pose_builder import Scales

__all__ = [
    "DRIVEN",
    "FAMILIES",
    "FRICTION",
    "PLAIN",
    "RandomMechanism",
    "Scales",
    "random_mechanism",
]
