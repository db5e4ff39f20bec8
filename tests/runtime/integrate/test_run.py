"""Chunks, interrupts, one compilation for all models, refusal of bad input."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from runtime.constraints import repartitioning as repartition
from runtime.core.outcomes import Outcome, Site
from runtime.hybrid import events, mode_selection
from runtime.integrate import initialization as start
from runtime.integrate import loop as driver
from runtime.integrate import sampling as outputs
from runtime.integrate import step
from runtime.integrate.method import EXPLICIT, find_method
from runtime.integrate.problem import Options
from tests.runtime.integrate.systems import PENDULUM, integrate, pendulum_problem, relay, run_relay

BALL = ((0.0, 1e4, 0.0, 1.0, 0.0, 0.0, 0.0),)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("chunk", [1, 7, 100])
@pytest.mark.parametrize("instants", [None, np.linspace(0.0, 5.0, 333)])
def test_chunks_do_not_change_a_bit(method, chunk, instants):
    ball = relay(*BALL, constant=-9.81, stiffness=1e4)
    turning = pendulum_problem(0.0, 8.0, 5.0)
    results = []
    for size in (None, chunk):
        settings = {"method": method, "t_eval": instants, "chunk": size}
        results.append(
            (
                run_relay(ball, 1.0, 0.0, 5.0, **settings),
                integrate(PENDULUM, turning, Options(**settings)),
            )
        )
    for whole, parts in zip(*results, strict=True):
        assert whole.statistics.steps == parts.statistics.steps
        for name in ("t", "q", "v", "modes", "final_q", "final_v"):
            assert np.array_equal(getattr(whole, name), getattr(parts, name)), name
        assert np.array_equal(whole.events.t, parts.events.t)
        assert np.array_equal(whole.events.q, parts.events.q)
        assert np.array_equal(whole.partitions.t, parts.partitions.t)
        assert np.array_equal(whole.partitions.independent, parts.partitions.independent)


def test_more_events_than_one_buffer_holds():
    ball = relay(*BALL, constant=-9.81, stiffness=1e4)
    r = run_relay(ball, 0.01, 0.0, 20.0, method="dop853", t_eval=[])
    assert r.events.t.size == r.statistics.events > 300
    assert np.all(np.diff(r.events.t) > 0.0)
    assert np.all(r.events.direction[1:] == -r.events.direction[:-1])


def test_second_model_compiles_nothing():
    functions = (
        driver.advance, start.start, step.take_trial_step, repartition.repartition, outputs.emit,
        events.locate_event, mode_selection.select_modes, mode_selection.initialize_modes,
        *(find_method(name).stages for name in EXPLICIT),
    )  # fmt: skip
    integrate(PENDULUM, pendulum_problem(np.pi, 0.0, 0.1), Options())
    run_relay(relay(*BALL, constant=-9.81), 1.0, 0.0, 0.1)
    run_relay(relay(stiffness=1.0), 1.0, 0.0, 0.1, method="dopri5")
    for function in functions:
        assert len(function.signatures) == 1
        assert len(function.nopython_signatures) == 1


def test_a_short_run_takes_over_no_signal(monkeypatch):
    monkeypatch.setattr(signal, "signal", lambda *_: pytest.fail("the signal was taken over"))
    r = integrate(PENDULUM, pendulum_problem(np.pi, 0.0, 1.0), Options())
    assert r.outcome == Outcome.OK
    assert r.statistics.steps < 128


def test_the_signal_is_handed_back():
    before = signal.getsignal(signal.SIGINT)
    r = integrate(PENDULUM, pendulum_problem(np.pi, 0.0, 100.0), Options())
    assert r.statistics.steps > 128
    assert signal.getsignal(signal.SIGINT) is before


def test_interrupt_keeps_what_was_computed():
    seen = []

    def progress(t, steps):
        seen.append((t, steps))
        if len(seen) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    r = integrate(
        PENDULUM, pendulum_problem(np.pi, 0.0, 1000.0), Options(chunk=50), progress=progress
    )
    assert r.outcome == Outcome.INTERRUPTED
    assert r.final_t == seen[-1][0]
    assert r.t[-1] == r.final_t
    assert r.t.size == r.statistics.steps + 1
    assert np.array_equal(r.q[-1], r.final_q)


def test_interrupted_samples_end_where_the_run_ended():
    def progress(t, steps):
        raise KeyboardInterrupt

    r = integrate(
        PENDULUM,
        pendulum_problem(np.pi, 0.0, 100.0),
        Options(chunk=50, t_eval=np.linspace(0.0, 100.0, 1001)),
        progress=progress,
    )
    assert r.outcome == Outcome.INTERRUPTED
    assert 0 < r.t.size < 1001
    assert r.t[-1] <= r.final_t < r.t[-1] + 0.1


def test_max_steps():
    r = integrate(PENDULUM, pendulum_problem(np.pi, 0.0, 1000.0), Options(max_steps=100))
    assert r.outcome == Outcome.MAX_STEPS
    assert r.statistics.steps + r.statistics.rejected == 100
    assert "max_steps" in r.outcome.advice


def test_no_time_at_all():
    r = integrate(PENDULUM, pendulum_problem(1.0, 2.0, 0.0), Options(t_eval=[0.0]))
    assert r.outcome == Outcome.OK
    assert r.t.tolist() == [0.0]


def test_late_start_and_given_modes_at_the_end():
    r = run_relay(relay(stiffness=1.0), 1.0, 0.0, 12.0, t0=10.0, t_eval=[10.0, 11.0, 12.0])
    np.testing.assert_allclose(r.q[:, 0], np.cos([0.0, 1.0, 2.0]), atol=1e-8)


def test_every_outcome_says_what_to_do():
    texts = [(outcome.meaning, outcome.advice) for outcome in Outcome]
    assert len(set(texts)) == len(Outcome)
    assert all(text.endswith(".") for pair in texts for text in pair)


def test_every_site_has_a_row_in_the_table_of_ends(root):
    page = (root / "docs/development/rooms/integration.md").read_text(encoding="utf-8")
    assert [site.name for site in Site if f"`{site.name}`" not in page] == ["NOWHERE"]


def test_a_new_process_loads_from_disk(root):
    code = (
        "from runtime.core.jit import prepare; from runtime.integrate import loop\n"
        "prepare(loop.advance)\n"
        "assert not sum(loop.advance.stats.cache_misses.values())\n"
        "print(sum(loop.advance.stats.cache_hits.values()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "1"
