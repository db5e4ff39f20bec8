"""Results that are written while their run goes on: the same bits, and what a failure leaves."""

import json
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from codegen import Model
from codegen.errors import InputError
from linkwright.cli.application import app
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.dynamics.stored_simulation import simulate_into
from runtime.integrate import recording_buffers
from runtime.machine_facade import Machine
from runtime.results import samples, zarr_store
from tests.runtime import bars

ROWS = 64  # of a chunk in these tests


def declaration() -> Model:
    model = Model("stored_swing", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    stop = model.parameter("stop", 0.3, unit="rad")
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("buffer", on=bob, value=-50.0 * (bob.phi - stop), when=bob.phi > stop)
    brake = model.sampled("brake", every=0.1, unit="N m")
    model.torque("braking", on=bob, value=brake)
    start = {bob.phi: -0.4, bob.omega: 4.0}
    model.scene("swing", ["gravity", "buffer"], start=start)
    model.scene("held", ["gravity", "braking"], start=start)
    return model


@pytest.fixture(scope="module")
def swing(workshop: Path) -> Machine:
    return load(declaration(), "swing", folder=workshop)


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zarr_store, "_MOST", ROWS)
    monkeypatch.setattr(recording_buffers, "_SINK_BYTES", 0)


def check_equal(store: Path, expected: xr.Dataset) -> xr.Dataset:
    """The store, whose variables and coordinates have the expected bits."""
    with xr.open_zarr(store, chunks=None) as read:
        found = read.load()
    assert set(found.variables) == set(expected.variables)
    for name, variable in expected.variables.items():
        values = found[name].values
        if variable.dtype.kind == "U":
            assert values.tolist() == variable.values.tolist()
        else:
            assert values.tobytes() == np.ascontiguousarray(variable.values).tobytes(), name
        assert found[name].dims == variable.dims
    return found


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("t_eval", [None, 5, 16, "steps"])
def test_a_store_has_the_bits_of_a_result_in_memory(
    swing: Machine, tmp_path: Path, t_eval: Any
) -> None:
    expected = swing.simulate(3.0, t_eval)
    result = swing.simulate(3.0, t_eval, out=tmp_path / "run.zarr")
    assert len(expected.events) == len(result.events) > 0
    for name, array in expected.samples._asdict().items():
        assert getattr(result.samples, name).tobytes() == array.tobytes(), name
    found = check_equal(tmp_path / "run.zarr", expected.data)
    assert found.attrs["outcome"] == "OK"
    assert found.attrs["message"] == expected.message
    assert json.loads(found.attrs["stats"])["steps"] == expected.stats["steps"]
    assert [path.name for path in tmp_path.iterdir()] == ["run.zarr"]
    assert result.at(1.234).q("bob.phi") == expected.at(1.234).q("bob.phi")


@pytest.mark.usefixtures("small_chunks")
def test_a_run_that_stops_early_adds_its_last_state(swing: Machine, tmp_path: Path) -> None:
    expected = swing.simulate(3.0, 100, max_steps=20)
    swing.simulate(3.0, 100, max_steps=20, out=tmp_path / "run.zarr")
    assert expected.outcome is Outcome.MAX_STEPS
    found = check_equal(tmp_path / "run.zarr", expected.data)
    assert found.attrs["outcome"] == "MAX_STEPS"


@pytest.mark.usefixtures("small_chunks")
def test_an_interruption_keeps_what_was_computed(swing: Machine, tmp_path: Path) -> None:
    calls, place = list[str](), tmp_path / "run.zarr"

    def interrupt(part: float) -> None:
        if place.exists():
            with xr.open_zarr(place, chunks=None) as read:
                calls.append(read.attrs["outcome"])
            raise KeyboardInterrupt

    result = simulate_into(place, swing.mechanism, 100.0, 2001, progress=interrupt)
    assert calls == ["RUNNING"]
    assert result.outcome is Outcome.INTERRUPTED
    with xr.open_zarr(place, chunks=None) as read:
        assert read.attrs["outcome"] == "INTERRUPTED"
        assert 0 < len(read.time) == len(result.t) < 2001
        expected, kept = swing.simulate(100.0, 2001), len(result.t) - 1
        assert read.q.values[:kept].tobytes() == expected.data.q.values[:kept].tobytes()


@pytest.mark.usefixtures("small_chunks")
def test_an_error_keeps_what_was_computed(workshop: Path, tmp_path: Path) -> None:
    machine = load(declaration(), "held", folder=workshop)

    def fail(sample: Any) -> float:
        if sample.t > 5.0:
            raise RuntimeError("no more answers")
        return 0.0

    with pytest.raises(RuntimeError, match="no more answers"):
        machine.simulate(10.0, 1001, controllers={"brake": fail}, out=tmp_path / "run.zarr")
    with xr.open_zarr(tmp_path / "run.zarr", chunks=None) as read:
        assert read.attrs["outcome"] == "FAILED"
        assert read.attrs["message"] == "RuntimeError: no more answers"
        assert 4.9 < read.time.values[-1] < 5.2


def test_what_a_run_holds_does_not_grow_with_its_instants(tmp_path: Path) -> None:
    chain, held = bars.chain(20), list[int]()
    for count in (500, 4_000, 16_000):
        tracemalloc.start()
        result = chain.simulate(1.0, count, out=tmp_path / f"run_{count}.zarr")
        held.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert len(result.t) == count
    more = 12_000 * samples.sample_bytes(chain.description)  # in the last of the results
    assert held[2] < held[1] + more / 4


def test_a_place_that_is_taken_and_other_runs_are_refused(swing: Machine, tmp_path: Path) -> None:
    place = tmp_path / "run.zarr"
    swing.simulate(0.1, 3, out=place)
    with pytest.raises(InputError, match=r"run\.zarr is there already\. Choose another name"):
        swing.simulate(0.1, 3, out=place)
    with pytest.raises(InputError, match=r"Choose a name that ends in \.zarr"):
        swing.simulate(0.1, 3, out=tmp_path / "run.nc")
    for words, why in (
        ({"accuracy": 1e-6}, "accuracy= makes several runs"),
        ({"formulation": "reduced"}, "finds the other coordinates at the end"),
        ({"until": {"up": ("bob.phi", ">", 0.2)}}, "until= makes two runs"),
    ):
        with pytest.raises(InputError, match=why):
            swing.simulate(0.1, 3, out=tmp_path / "other.zarr", **words)
    assert [path.name for path in tmp_path.iterdir()] == ["run.zarr"]


def test_samples_that_do_not_fit_into_memory_are_refused_by_number(
    swing: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(samples, "free_bytes", lambda: 10**7)
    message = r"the samples at 200000 instants take 0\.0\d+ GB, and 0\.01 GB of memory are free"
    with pytest.raises(InputError, match=message):
        swing.simulate(1.0, 200_000)
    with pytest.raises(InputError, match=message.replace("200000", "200001")):
        swing.simulate(1.0, np.linspace(0.0, 1.0, 200_001))
    monkeypatch.setattr(samples, "free_bytes", lambda: 3 * 10**7)
    assert len(swing.simulate(1.0, 200_000, out=tmp_path / "run.zarr").t) == 200_000
    assert samples.sample_bytes(swing.description) * 200_000 > 3 * 10**7
    monkeypatch.setattr(samples, "free_bytes", lambda: None)  # where the system does not tell
    assert swing.simulate(1.0, 3).outcome is Outcome.OK


def test_what_is_free_is_known_here() -> None:
    free = samples.free_bytes()
    assert free is None or free > 2**20


def test_a_command_writes_the_store_while_it_runs(
    library: Callable[[str, str], Machine], root: Path, tmp_path: Path
) -> None:
    machine, place = library("slider_crank", "compressor"), tmp_path / "run.zarr"
    words = ["simulate", str(root / "models" / "slider_crank.py"), "--scene", "compressor"]
    words += ["--t-end", "0.01", "--points", "11", "--stream"]
    without = CliRunner().invoke(app, words)
    assert without.exit_code == 2
    assert "name the store, --out run.zarr" in without.output
    done = CliRunner().invoke(app, [*words, "--out", str(place)])
    assert done.exit_code == 0
    assert f"Saved: 11 instants in {place}" in done.output
    check_equal(place, machine.simulate(0.01, 11).data)
    again = CliRunner().invoke(app, [*words, "--out", str(place)])
    assert again.exit_code == 2
    assert "run.zarr is there" in again.output
