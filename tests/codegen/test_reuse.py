"""What one scene of a machine has derived, the others take over."""

from pathlib import Path

import pytest

from codegen.derive import constraint_terms, effect_terms
from codegen.derive import switching_functions as switches
from codegen.derive.equations import derive
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.workbench import Interpreted

DERIVED = (constraint_terms._derive, effect_terms._pieces, switches.rate)


def derivations() -> int:
    """Statements, potentials, forces and switching functions that SymPy has worked on so far."""
    return sum(derived.cache_info().misses for derived in DERIVED)


def test_second_scene_reuses_what_was_derived(root: Path) -> None:
    model = read_model(root / "models" / "film_follower.py").model
    for derived in DERIVED:
        derived.cache_clear()  # what other tests have derived
    begun = derivations()
    Interpreted(model, "motor")
    first = derivations() - begun
    Interpreted(model, "constant_torque")
    second = derivations() - begun - first
    assert second <= first / 2
    Interpreted(model, "motor")
    assert derivations() == begun + first + second


@pytest.mark.parametrize(
    ("machine", "first", "others"),
    [
        ("slider_crank", "compressor",
         ("compressor_massless_rod", "inverse_dynamics", "kinematics", "gas_equilibrium")),
        ("quick_return", "shaper",
         ("inverse_dynamics", "kinematics", "kinematics_composite", "gravity_equilibrium")),
    ],
)  # fmt: skip
def test_other_scenes_derive_less_than_half_of_the_first(
    root: Path, machine: str, first: str, others: tuple[str, ...]
) -> None:
    model = read_model(root / "models" / f"{machine}.py").model
    for other in others:
        for derived in DERIVED:
            derived.cache_clear()
        begun = derivations()
        derive(model, valid_scenes(model, first)[0])
        needed = derivations() - begun
        derive(model, valid_scenes(model, other)[0])
        assert derivations() - begun - needed <= needed / 2, other
        again = derivations()
        less = model.scene(first).without("motor")  # all that is in it stands there already
        derive(model, valid_scenes(model, less)[0])
        assert derivations() == again
