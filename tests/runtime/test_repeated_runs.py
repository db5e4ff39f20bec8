"""Runs of one machine after and beside each other: what is kept for the next one changes no bit."""

import gc
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from runtime import load
from runtime.dynamics import prepared_simulation, simulation
from runtime.integrate import wiring
from runtime.machine_facade import Machine
from runtime.results.result import Result

COUNTED = "steps", "rejected", "rhs_evaluations", "corrections", "returns", "events", "repartitions"


def bits(machine: Machine, **settings: Any) -> tuple[Any, ...]:
    """All that a run answers, but for seconds; the words of a refusal."""
    try:
        r = machine.simulate(**{"t_end": 0.05, "t_eval": 7, "progress": False, **settings})
    except LinkwrightError as error:
        return type(error), str(error)
    return of(r)


def of(r: Result) -> tuple[Any, ...]:
    """The same of a result."""
    events = [(e.name, e.time, e.direction, e.q.tobytes(), e.v.tobytes()) for e in r.events]
    counts = [r.stats[name] for name in COUNTED]
    ends = r.outcome, r.message, r.site, r.partitions, r.not_unique, r.parameters
    return *(array.tobytes() for array in r.samples), events, counts, *ends


def fresh(machine: Machine) -> Machine:
    """The same machine, for which nothing is kept."""
    wiring._lay_out.cache_clear()
    return Machine(replace(machine.mechanism))


SETTINGS: dict[str, tuple[dict[str, Any], ...]] = {
    "slider_crank/compressor": (
        {},
        {"formulation": "reduced"},
        {"parameters": {"rod_length": 3.6}},
        {"parameters": {"rod_length": 3.6}, "formulation": "reduced"},
        {"start": {"crank.phi": 3.0}},
        {"start": {"crank.omega": 31.0}, "formulation": "reduced"},
        {"t_start": 0.01, "method": "tsit5"},
        {"rtol": 1e-5, "atol": 1e-4, "t_eval": "steps", "max_step": 1e-3},
        {"t_end": 0.02, "correction": "projection"},
        {"method": "radau5"},
        {"parameters": {"rod_length": -1.0}},
        {"start": {"crank.phi": 0.3, "slider.x": 7.0}},
    ),
    "hard/guide_friction/rocking": (  # its loop writes forces and shares among the parameters
        {"t_end": 1.0},
        {"t_end": 1.0, "rtol": 1e-5},
        {"t_end": 0.5, "method": "dopri5", "t_eval": "steps"},
    ),
    "hard/bouncing_ball/dropped": (
        {"t_end": 1.5},
        {"t_end": 1.5, "parameters": {"restitution": 0.7}},
        {"t_end": 1.5, "parameters": {"restitution": 0.2}, "method": "tsit5"},
    ),
    "robot_arm/sampled": ({"t_end": 0.5}, {"t_end": 0.3, "method": "dopri5"}, {"t_start": 0.004}),
    "quarter_car/bump": ({"t_end": 0.5}, {"t_end": 0.8}, {"t_end": 0.5, "t_start": 0.1}),
    "trebuchet/throw": ({"t_end": 1.5}, {"t_end": 2.0, "rtol": 1e-6}),
}


@pytest.mark.parametrize("of_library", SETTINGS)
def test_runs_between_change_no_bit(of_library: str, library: Callable[..., Machine]) -> None:
    machine, settings = library(*of_library.rsplit("/", 1)), SETTINGS[of_library]
    alone = [bits(fresh(machine), **words) for words in settings]
    assert len({str(answer) for answer in alone}) == len(settings)
    machine = fresh(machine)
    order = [*range(len(settings)), *range(len(settings))[::-1], *range(len(settings))]
    for k in order:
        assert bits(machine, **settings[k]) == alone[k], settings[k]


def test_runs_beside_each_other_change_no_bit(library: Callable[..., Machine]) -> None:
    for name in ("slider_crank/compressor", "hard/guide_friction/rocking"):
        machine, settings = library(*name.rsplit("/", 1)), SETTINGS[name]
        alone, shared = [bits(fresh(machine), **words) for words in settings], fresh(machine)
        jobs = [*range(len(settings))] * 6
        with ThreadPoolExecutor(6) as threads:
            found = [*threads.map(lambda k: bits(shared, **settings[k]), jobs)]  # noqa: B023
        assert found == [alone[k] for k in jobs]


def test_a_result_is_its_own_whatever_runs_follow(library: Callable[..., Machine]) -> None:
    machine = fresh(library("hard/guide_friction", "rocking"))
    first = machine.simulate(1.0, 7)
    before, between = of(first), of(first.at(0.37))
    machine.simulate(2.0, "steps", rtol=1e-5)
    first.resume(1.5, 3)
    assert (of(first), of(first.at(0.37))) == (before, between)


def test_what_is_kept_is_as_it_was_made(library: Callable[..., Machine]) -> None:
    machine = fresh(library("hard/guide_friction", "rocking"))
    run = machine.simulate(1.0, 7)
    (kept,), given = machine.mechanism.starts.values(), machine.parameter_values()
    assert (run._motion.coordinates.ready.p != given).any()  # type: ignore[union-attr]
    assert (kept.ready.p == given).all()
    arrays = [kept.ready.p, kept.begin.q, kept.begin.v, kept.ready.sizes, kept.mobility]
    before = [array.tobytes() for array in arrays]
    table = wiring.wire(kept.system, "dop853", kept.ready.p, 8)
    block = table.block.copy()
    for _ in range(3):
        machine.simulate(1.0, 7)
    wiring.wire(kept.system, "dop853", kept.ready.p, 8).block[:] = 7
    assert [array.tobytes() for array in arrays] == before
    assert wiring.wire(kept.system, "dop853", kept.ready.p, 8).block.tobytes() == block.tobytes()


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
def test_runs_share_no_parameters(formulation: str, library: Callable[..., Machine]) -> None:
    machine = fresh(library("slider_crank", "compressor"))
    machine.simulate(0.01, 3, formulation=formulation)
    (kept,) = machine.mechanism.starts.values()

    def parameters(run: Any) -> list[np.ndarray]:
        first = [run.first.p] if run is kept and formulation == "reduced" else []
        problem = run.problem(run.begin.t, run.begin.q, run.begin.v)
        return [run.ready.p, run.ready.equations.p, run.equations.p, problem.p, *first]

    one, other = kept.again(1.0), kept.again(2.0)
    for left, right in ((one, other), (one, kept), (other, kept)):
        for p in parameters(left):
            assert not any(np.shares_memory(p, theirs) for theirs in parameters(right))


@pytest.fixture
def assemblies(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Grows by one with each start that is assembled."""
    found: list[Any] = []
    assemble = prepared_simulation.assemble

    def counted(*arguments: Any) -> Any:
        found.append(arguments)
        return assemble(*arguments)

    monkeypatch.setattr(prepared_simulation, "assemble", counted)
    return found


def test_a_start_is_assembled_once(assemblies: list[Any], gas: Machine) -> None:
    machine, counts, start = fresh(gas), [], {"crank.phi": 0.4}
    for words in (
        {}, {"t_end": 0.1, "t_eval": "steps"}, {"rtol": 1e-4}, {"start": start}, {"start": start},
        {"start": {"crank.phi": 0.0}}, {"start": {"crank.phi": -0.0}}, {"method": "tsit5"},
        {"t_start": 0.01}, {"correction": "projection"}, {},
    ):  # fmt: skip
        bits(machine, **words)
        counts.append(len(assemblies))
    assert counts == [1, 1, 1, 2, 2, 3, 4, 5, 6, 7, 7]
    start["crank.phi"] = 0.5  # of a mapping that a run was given before
    assert machine.simulate(0.05, 3, start=start).q("crank.phi")[0] == 0.5


def test_states_and_functions_of_time_are_prepared_for_each_run(
    assemblies: list[Any], gas: Machine, library: Callable[..., Machine]
) -> None:
    machine = fresh(gas)
    end = machine.simulate(0.05, 3)
    for _ in range(2):
        machine.simulate(0.1, 3, start=end)
    assert len(assemblies) == 3
    assert len(machine.mechanism.starts) == 1
    driven = fresh(library("quarter_car", "bump"))
    for _ in range(2):
        driven.simulate(0.1, 3)
    assert not driven.mechanism.starts


def test_few_starts_are_kept_and_as_long_as_their_machine(tmp_path: Path) -> None:
    model = Model("swing", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.scene("free", effects=["gravity"], start={bob.phi: 0.3})
    machine = load(model, "free", folder=tmp_path)
    for phi in np.linspace(0.0, 1.0, 3 * simulation._KEPT):
        machine.simulate(0.01, 2, start={"bob.phi": phi})
    assert 0 < len(machine.mechanism.starts) <= simulation._KEPT
    known = weakref.ref(machine.mechanism)
    del machine
    gc.collect()
    assert known() is None


def test_a_refused_formulation_is_refused_each_time(library: Callable[..., Machine]) -> None:
    machine = fresh(library("hard/guide_friction", "rocking"))
    machine.simulate(0.1, 3)
    for _ in range(2):
        with pytest.raises(InputError, match="formulation = 'polar'"):
            machine.simulate(0.1, 3, formulation="polar")  # type: ignore[arg-type]
