"""A sweep in this process: its rows are those of single runs, failures among them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from codegen import Model
from codegen.errors import InputError, ParameterError
from runtime import load, load_study, sweep
from runtime.studies.quantity import parse_quantity
from runtime.sweeps.study import Study


def test_rows_have_the_bits_of_single_runs(study: Study) -> None:
    machine = load("slider_crank", scene="compressor")
    for run in (1, 6, 11):
        single = machine.simulate(0.05, 21, parameters=study.point(run), progress=False)
        assert study.data["end:crank.omega"].values[run] == single.v("crank.omega")[-1]
        assert study.data["max:B.fx"].values[run] == parse_quantity("max:B.fx").read(single).value
        assert (study.data["crank.phi"].values[run] == single.q("crank.phi")).all()
        assert study.data["message"].values[run] == single.message
        assert study.data["t_last"].values[run] == 0.05
        again = study.member(run)
        assert (again.samples.q == single.samples.q).all()
        assert again.parameters == single.parameters


def test_failures_are_rows(study: Study) -> None:
    assert study.outcomes == {"OK": 9, "REFUSED": 3}
    assert study.complete
    assert study.failures["rod_length"].values.tolist() == [-1.0, -1.0, -1.0]
    row = study.data.isel(run=0)
    assert np.isnan(row["max:B.fx"])
    assert np.isnan(row["crank.phi"]).all()
    assert "it must be greater than zero" in str(row["message"].values)
    with pytest.raises(ParameterError):
        study.member(0)


def test_a_machine_that_does_not_assemble_is_a_row(swept: Callable[..., Study]) -> None:
    found = swept(over={"crank.phi": [1.57, 3.14]}, parameters={"rod_length": 1.0})
    assert found.outcomes == {"REFUSED": 1, "OK": 1}
    assert "joint" in str(found.data["message"].values[0])
    assert "run 0, crank.phi = 1.57:" in repr(found)


def test_a_study_as_arrays(study: Study) -> None:
    assert study["max:B.fx"].dims == ("J1", "rod_length")
    assert study["crank.phi"].dims == ("J1", "rod_length", "t")
    assert study["max:B.fx"].attrs["units"] == "N"
    assert study.data["J1"].attrs["units"] == "kg m^2"
    table = study.statistics()
    assert table.loc["max:B.fx", "runs"] == 9
    assert table.loc["max:B.fx", "max"] == float(study["max:B.fx"].max())
    assert study.statistics(0.25)["0.25"].notna().all()
    text = repr(study)
    assert "12 runs (grid) over J1, rod_length" in text
    assert "REFUSED: 3 runs" in text
    assert "run 0, J1 = 200, rod_length = -1:" in text
    assert "<table>" in study._repr_html_()
    with pytest.raises(InputError, match=r"nearest: max:B\.fx"):
        study["max:B.fy"]
    for wrong in (12, -13, 1.5, True, "a"):
        with pytest.raises(InputError, match="no run"):
            study.member(wrong)  # type: ignore[arg-type]


def test_a_grid_has_the_order_of_the_values(swept: Callable[..., Study]) -> None:
    over = {"J1": [450.0, 225.0, 900.0], "rod_length": [4.0, -1.0, 3.5]}
    found = swept(over=over)
    for name, values in over.items():
        assert found.grid[name].values.tolist() == values
    rows = found.data["max:B.fx"].values.reshape(3, 3)
    assert np.array_equal(found["max:B.fx"].values, rows, equal_nan=True)


def test_a_study_from_a_file_is_data_alone(study: Study) -> None:
    loaded = load_study(study.path)
    assert loaded.data.equals(study.data)
    with pytest.raises(InputError, match="without its machine"):
        loaded.member(3)
    machine = load("slider_crank", scene="compressor")
    again = load_study(study.path, machine=machine).member(3)
    assert (again.samples.q == study.member(3).samples.q).all()
    with pytest.raises(InputError, match="the model has changed since, or is another one"):
        load_study(study.path, machine=load("slider_crank", scene="compressor_massless_rod"))
    with pytest.raises(InputError, match="no such folder"):
        load_study(study.path / "nothing")
    with pytest.raises(InputError, match="not written by a sweep"):
        load_study(study.path.parent)


def test_a_plain_reader_opens_the_store(study: Study) -> None:
    found = xr.open_zarr(study.path, consolidated=False, chunks=None)
    assert set(found.coords) == {"J1", "rod_length", "t"}
    assert found["max(B.fx)"].attrs == {"units": "N", "quantity": "max:B.fx"}
    assert found["outcome"].values.tolist().count("OK") == 9


def test_start_values_vary_too(swept: Callable[..., Study]) -> None:
    found = swept(over={"crank.omega": [20.0, 30.0], "J1": 450})
    machine = load("slider_crank", scene="compressor")
    slow = machine.simulate(0.05, 21, start={"crank.omega": 20.0}, progress=False)
    assert found["end:crank.omega"].dims == ("crank.omega", "J1")
    assert found.data["end:crank.omega"][0] == slow.v("crank.omega")[-1]
    assert found.member(0).v("crank.omega")[-1] == slow.v("crank.omega")[-1]


def test_other_analyses(tmp_path: Path) -> None:
    common = {"over": {"rod_length": [3.0, 3.5]}, "workers": 0, "progress": False}
    driven = sweep(
        "slider_crank", "inverse_dynamics", quantities=["peak:crank_drive.torque"], t_end=1.0,
        points=51, out=tmp_path / "a.zarr", **common,
    )  # fmt: skip
    machine = load("slider_crank", scene="inverse_dynamics")
    single = machine.inverse_dynamics(np.linspace(0, 1, 51), parameters={"rod_length": 3.0})
    assert driven.data["peak:crank_drive.torque"][0] == pytest.approx(
        abs(single.reaction("crank_drive", "torque")).max(), rel=1e-2
    )
    rest = sweep(
        "slider_crank", "gravity_equilibrium", quantities=["crank.phi"], analysis="equilibrium",
        out=tmp_path / "b.zarr", **common,
    )  # fmt: skip
    assert rest.outcomes == {"OK": 2}
    moved = sweep(
        "slider_crank", "kinematics", quantities=["slider.x"], t_end=0.25, analysis="kinematics",
        out=tmp_path / "c.zarr", **common,
    )  # fmt: skip
    assert moved.member(1).analysis == "kinematics"


def test_functions_of_a_result(swept: Callable[..., Study]) -> None:
    def stroke(result: Any) -> float:
        return float(np.ptp(result.q("slider.x")))

    def broken(result: Any) -> float:
        return 1.0 / 0.0

    wanted = {"stroke": stroke, "broken": broken, "top": "max:B.fx"}
    found = swept(over={"J1": [225, 450]}, quantities=wanted)
    assert found.data["stroke"][1] == np.ptp(found.member(1).q("slider.x"))
    assert np.isnan(found.data["broken"]).all()
    assert "ZeroDivisionError" in str(found.data["message"].values[0])
    assert found.outcomes == {"OK": 2}


def test_options_reach_the_runs(swept: Callable[..., Study], tmp_path: Path) -> None:
    found = swept(over={"J1": [225, 450]}, max_steps=3)
    assert found.outcomes == {"MAX_STEPS": 2}
    assert (found.data["t_last"] < 0.05).all()
    until = {"fast": ("crank.omega", "<", 29.9)}
    words = {"over": {"J1": [225, 450]}, "formulation": "reduced", "until": until}
    found = swept(out=tmp_path / "r.zarr", **words)
    assert (found.data["t_last"] < 0.05).all()
    assert found.outcomes == {"OK": 2}


def test_everything_that_is_wrong_is_said_at_once(about: dict[str, Any], tmp_path: Path) -> None:
    out = tmp_path / "s.zarr"
    wrong = about | {"quantities": ["max:B.fx", "most:B.fx"], "t_end": -1.0}
    with pytest.raises(InputError) as caught:
        sweep(over={"J3": [1.0], "drive_speed": [2.0]}, out=out, keep=["B.fz"], rtol=-1, **wrong)
    text = str(caught.value)
    for part in ("'J3'", "drive_speed", "no reduction 'most'", "'B.fz'", "rtol is -1", "time span"):
        assert part in text
    with pytest.raises(InputError, match=r"no series 'B\.fz'") as caught:
        sweep(over={"J1": [1.0]}, out=out, **about | {"quantities": ["max:B.fz"]})
    with pytest.raises(InputError) as caught:
        sweep(over={"J1": "1:2"}, out=tmp_path / "none" / "s.zarr", **about)
    assert len(caught.value.problems) == 2
    with pytest.raises(InputError, match="J1 varies, and has one value as well"):
        sweep(over={"J1": [1.0]}, parameters={"J1": 2.0}, out=out, **about)
    with pytest.raises(InputError, match="would name several columns"):
        sweep(over={"J1": [1.0]}, keep=["B.fx", "B.fx"], out=out, **about)
    with pytest.raises(InputError, match="cannot name a column"):
        sweep(over={"J1": [1.0]}, out=out, **about | {"quantities": {"outcome": "max:B.fx"}})
    with pytest.raises(InputError, match="over is 3; it must be factors by name"):
        sweep(over=3, out=out, **about)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_points_and_their_units(tmp_path: Path) -> None:
    model = Model("metric", gravity=(0, -9.81))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    length = model.parameter("l", 1.0, unit="m")
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    model.scene("swing", start={bob.phi: 0.0, bob.omega: 1.0})
    common: dict[str, Any] = {
        "t_end": 0.1, "points": 11, "folder": tmp_path, "workers": 0, "progress": False,
        "quantities": ["bob.phi"],
    }  # fmt: skip
    points = xr.Dataset({"l": ("run", [1000.0, 2000.0], {"units": "mm"})})
    found = sweep(model, over=points, out="a.zarr", **common)
    assert found.data["l"].values.tolist() == [1.0, 2.0]
    assert found.data["l"].attrs["units"] == "m"
    with pytest.raises(InputError) as misfits:
        sweep(
            model, over=["l=1 kg,2 kg", "k=1 mm,2 mm"], out="a.zarr", resume=True,
            **common | {"quantities": ["no.series"], "t_end": -1.0},
        )  # fmt: skip
    assert [text.split()[0] for text in misfits.value.problems[:1]] == ["l:"]
    assert len(misfits.value.problems) == 4
    failed = sweep(
        model, over={"l": [1.0, 2.0]}, out="b.zarr", max_steps=1,
        **common | {"quantities": ["max:bob.phi", "rate:bob.x"]},
    )  # fmt: skip
    assert set(failed.outcomes) == {"MAX_STEPS"}
    assert failed.data["max:bob.phi"].attrs["units"] == "rad"
    assert failed.data["rate:bob.x"].attrs["units"] == "m/s"
    with pytest.raises(InputError) as raised:
        sweep(
            model, over={"l": [1.0, 2.0]}, out="c.zarr", max_steps=1,
            **common | {"quantities": ["max:no.such", "event:nothing", "max:bob.phj"]},
        )  # fmt: skip
    assert len(raised.value.problems) == 3
    assert sorted(path.name for path in tmp_path.glob("*.zarr")) == ["a.zarr", "b.zarr"]
