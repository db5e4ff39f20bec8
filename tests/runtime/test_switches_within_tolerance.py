"""Events that the tolerance alone makes are counted and named in the message."""

from collections.abc import Callable

import pytest

from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine


@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_a_dead_centre_on_a_switching_surface(
    library: Callable[[str, str], Machine], method: str
) -> None:
    """The compressor's slider turns where x = 1.5 m: it touches x < 1.5 and does not cross it."""
    machine, heavy = library("slider_crank", "compressor"), {"J1": 900.0}
    exact = machine.simulate(1.0, rtol=1e-12, parameters=heavy, progress=False)
    loose = machine.simulate(1.0, rtol=1e-6, method=method, parameters=heavy, progress=False)
    assert exact.stats["events_within_tolerance"] == 0
    assert "within the tolerance" not in exact.message
    surplus = len(loose.events) - len(exact.events)
    assert surplus > 0
    assert loose.outcome is Outcome.OK
    assert loose.stats["events_within_tolerance"] == surplus
    assert f"{surplus} of {len(loose.events)} events lie within the tolerance" in loose.message
    assert "gas: slider_x < 1.5" in loose.message


def test_a_stiff_contact_that_opens_gently(library: Callable[[str, str], Machine]) -> None:
    """At the end of a long contact its force is a newton, and its depth a micrometre."""
    machine, soft = library("coil_spring", "impact_damped"), {"k": 30.0}
    exact = machine.simulate(20.0, rtol=1e-11, parameters=soft, progress=False)
    loose = machine.simulate(20.0, rtol=1e-6, method="dopri5", parameters=soft, progress=False)
    assert exact.stats["events_within_tolerance"] == 0
    assert len(loose.events) > len(exact.events)
    assert loose.stats["events_within_tolerance"] >= len(loose.events) - len(exact.events)
    assert "damped_contact: mass_6_x - striker_x > 0" in loose.message
