"""An interrupt is neither lost nor does it cost what was computed."""

import signal
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from codegen.termination_signals import SignalDeferral
from runtime.core.outcomes import Outcome
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.prescribed_motion import kinematics
from runtime.integrate.problem import Trajectory
from runtime.machine_facade import Machine


@pytest.fixture(autouse=True)
def keyboard() -> Iterator[None]:
    """The interrupt as a terminal has it: a shell's background processes ignore it."""
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, usual)


def test_a_deferral_raises_at_its_end() -> None:
    reached = False
    with pytest.raises(KeyboardInterrupt), SignalDeferral() as outer:  # noqa: PT012
        with SignalDeferral() as inner:
            signal.raise_signal(signal.SIGINT)
            assert inner.arrived
        assert outer.arrived
        reached = True
    assert reached
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_answered_interrupt_is_not_raised() -> None:
    with SignalDeferral() as outer:
        with SignalDeferral() as inner:
            signal.raise_signal(signal.SIGINT)
            inner.answered = True
        assert outer.arrived
    with SignalDeferral() as later:
        assert not later.arrived


def test_an_interrupt_is_not_lost_where_an_error_ends_the_block() -> None:
    with pytest.raises(KeyboardInterrupt) as caught, SignalDeferral():  # noqa: PT012
        signal.raise_signal(signal.SIGINT)
        raise ZeroDivisionError
    assert isinstance(caught.value.__context__, ZeroDivisionError)


@pytest.mark.parametrize("interrupted", [1, 2, 3])
@pytest.mark.parametrize("within", [True, False])
def test_a_search_for_an_accuracy_ends_at_once(
    pendulum: Machine, monkeypatch: pytest.MonkeyPatch, interrupted: int, within: bool
) -> None:
    """Within a run, or after its last step: no further run is made, and the best is kept."""
    runs, run = [], PreparedSimulation.run

    def interrupt(
        self: PreparedSimulation, taken: object, options: object, _: object
    ) -> Trajectory:
        def progress(fraction: float) -> None:
            if within and len(runs) == interrupted:
                signal.raise_signal(signal.SIGINT)

        runs.append(options)
        path = run(self, taken, options, progress)  # type: ignore[arg-type]
        if not within and len(runs) == interrupted:
            signal.raise_signal(signal.SIGINT)
        return path

    monkeypatch.setattr(PreparedSimulation, "run", interrupt)
    # So tight a target needs several runs, and so many steps that a run returns between them.
    result = pendulum.simulate(
        400.0, np.linspace(0.0, 400.0, 11), accuracy=1e-6, progress=False, method="tsit5"
    )
    assert len(runs) == interrupted
    assert result.outcome is Outcome.INTERRUPTED
    assert f"Interrupted in run {interrupted} of the search for an accuracy" in result.message
    assert ("its error is about" in result.message) is (interrupted > 2)
    if interrupted > 1 or not within:
        assert result.t[-1] == 400.0


def test_a_driven_motion_keeps_what_it_has_reached(make: Callable[..., Machine]) -> None:
    driven = make("slider_crank", "driven", driven=True)
    times = np.linspace(0.0, 1e4, 200_001)

    def progress(fraction: float) -> None:
        if fraction > 0.1:
            signal.raise_signal(signal.SIGINT)

    result = kinematics(driven.mechanism, times, progress=progress)
    assert result.outcome is Outcome.INTERRUPTED
    assert 0.1 < result.t[-1] / 1e4 < 0.2
    assert "The results up to this time are kept" in result.message
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
