"""Sensitivity, pictures, and the command of a sweep."""

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from codegen.errors import InputError
from linkwright.cli.application import app
from runtime import sweep
from runtime.sweeps.study import Study

OVER = {"J1": "400:500", "motor_torque": ("normal", 41450.0, 1.0)}


@pytest.fixture(scope="module")
def sampled(about: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A tolerance stack in which one factor hardly matters."""
    out = tmp_path_factory.mktemp("sampled") / "s.zarr"
    return sweep(over=OVER, sample="lhs", count=100, seed=3, out=out, workers=0, **about)


def test_indices_of_sobol(swept: Callable[..., Study]) -> None:
    pytest.importorskip("SALib")
    found = swept(over=OVER, sample="saltelli", count=32)
    assert len(found) == 32 * 4
    table = found.sensitivity("crank.omega")
    assert table.loc["J1", "ST"] == pytest.approx(1.0, abs=0.2)
    assert table.loc["motor_torque", "ST"] < 1e-3
    assert (found.sensitivity("crank.omega") == table).all(axis=None)


def test_indices_of_any_sample(sampled: Study, study: Study) -> None:
    pytest.importorskip("SALib")
    table = sampled.sensitivity()
    assert table.loc["J1", "delta"] > 3 * table.loc["motor_torque", "delta"]
    with pytest.raises(InputError, match="the design is a grid"):
        study.sensitivity()
    with pytest.raises(InputError, match="nearest"):
        sampled.sensitivity("max:B.fy")
    with pytest.raises(InputError, match=r"nearest: max:B\.fx"):
        sampled.unit("max:B.fy")


def test_a_tolerance_stack(sampled: Study) -> None:
    table = sampled.statistics(0.05, 0.95)
    row = table.loc["end:crank.omega"]
    assert row["min"] < row["0.05"] < row["mean"] < row["0.95"] < row["max"]
    torque = sampled.data["motor_torque"].values
    assert torque.std() == pytest.approx(1.0, rel=0.05)
    with pytest.raises(InputError, match="share is 2"):
        sampled.statistics(2.0)
    with pytest.raises(InputError, match="is a sample of points and no grid"):
        _ = sampled.grid


def test_pictures_of_one_two_and_more_factors(
    study: Study, sampled: Study, swept: Callable[..., Study], tmp_path: Path
) -> None:
    one = swept(over={"J1": [225, 450, 900]}, out=tmp_path / "a.zarr")
    (axes,) = one.plot("crank.omega").axes
    assert axes.get_xlabel() == "J1 (kg m^2)"
    assert axes.get_ylabel() == "end:crank.omega (rad/s)"
    x, y = axes.lines[0].get_data()
    assert x.tolist() == [225, 450, 900]
    assert (y == one.data["end:crank.omega"].values).all()
    axes, colours = study.plot().axes
    shown = axes.collections[0].get_array()
    assert np.ma.filled(shown, np.nan).shape == (4, 3)
    assert len(axes.lines[0].get_data()[0]) == 3  # crosses of the runs that failed
    assert colours.get_ylabel() == "max:B.fx (N)"
    points = sampled.plot().axes[0].collections[0]
    assert len(points.get_offsets()) == 100
    over = {"J1": "200:1000", "rod_length": "3:4", "motor_torque": "40000:42000"}
    three = swept(over=over, sample="halton", count=16)
    axes = three.plot().axes[0]
    assert len(axes.collections[0].get_segments()) == 16
    labels = [text.get_text() for text in axes.get_xticklabels()]
    assert labels[0] == "J1 (kg m^2)"
    assert labels[-1] == "max:B.fx (N)"


def command(out: Path, over: str) -> list[str]:
    return ["sweep", "slider_crank", "--scene", "compressor", "--over", over,
            "--quantity", "max:B.fx", "--t-end", "0.05", "--points", "21", "--workers", "0",
            "--out", str(out), "--json"]  # fmt: skip


def test_the_command(tmp_path: Path) -> None:
    words, picture = command(tmp_path / "s.zarr", "J1=200:1000:4"), tmp_path / "s.png"
    done = CliRunner().invoke(app, [*words, "--picture", str(picture)])
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["ok"]
    assert answer["outcomes"] == {"OK": 4}
    assert "max:B.fx: from" in done.stderr
    assert picture.stat().st_size > 1000
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert "Go on with it by --resume" in done.stderr
    assert CliRunner().invoke(app, [*words, "--resume"]).exit_code == 0
    done = CliRunner().invoke(app, [*words, "--resume", "--set", "rod_length=3.4"])
    assert done.exit_code == 2
    assert "parameters, rod_length was not given and is 3.4" in done.stderr
    done = CliRunner().invoke(app, [*words[:5], "J1=1:2", *words[6:-2], "none/s.zarr"])
    assert done.exit_code == 2
    assert done.stderr.count("error: ") == 2


def test_a_command_of_which_no_run_succeeds(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, command(tmp_path / "s.zarr", "rod_length=-1,-2"))
    assert done.exit_code == 1, done.stderr
    assert json.loads(done.stdout)["ok"] is False
    assert "REFUSED: 2 runs" in done.stderr


def test_a_cluster_without_workers_is_named(
    swept: Callable[..., Study], monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("runtime.sweeps.execution._WORKER_PATIENCE", 0.5)
    cluster = distributed.LocalCluster(
        n_workers=0, processes=False, dashboard_address="127.0.0.1:0"
    )

    def add_a_worker() -> None:
        while not cluster.scheduler.tasks:
            time.sleep(0.05)
        time.sleep(2.0)
        cluster.scale(1)

    with cluster:
        threading.Thread(target=add_a_worker, daemon=True).start()
        with pytest.warns(UserWarning, match="has no workers; the sweep waits for them"):
            found = swept(over={"J1": "200:300:9"}, scheduler=cluster.scheduler_address)
    assert found.outcomes == {"OK": 9}


def test_a_cluster_that_is_not_there(swept: Callable[..., Study]) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match="No Dask scheduler answers at nowhere"):
        swept(over={"J1": [200.0]}, scheduler="nowhere://1")
