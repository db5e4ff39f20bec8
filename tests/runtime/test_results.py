"""Results: labels, names, files whole or not at all, pictures."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from codegen.errors import InputError
from runtime.machine_facade import Machine
from runtime.results.result import Result


@pytest.fixture(scope="module")
def result(driven: Machine) -> Result:
    return driven.inverse_dynamics(np.linspace(0.0, 1.0, 11))


def test_dataset_is_labelled(result: Result) -> None:
    data = result.data
    assert data["q"].dims == ("time", "coordinate")
    assert data["reaction"].dims == ("time", "joint", "component")
    np.testing.assert_array_equal(data["q"].sel(coordinate="slider.x"), result.q("slider.x"))
    torque = data["reaction"].sel(joint="crank_drive", component="torque")
    np.testing.assert_array_equal(torque, result.reaction("crank_drive", "torque"))
    assert bool(np.isnan(data["reaction"].sel(joint="A", component="torque")).all())
    np.testing.assert_allclose(
        data["energy"].sel(part="total"),
        data["energy"].sel(part=["kinetic", "potential"]).sum("part"),
    )
    assert data["time"].attrs["units"] == "s"
    assert not any(", " in variable.attrs.get("units", "") for variable in data.values())
    assert "units" not in data["q"].attrs  # metres and radians: one unit a coordinate
    assert data["velocity_unit"].sel(coordinate="crank.phi").item() == "rad/s"
    assert data["acceleration_unit"].sel(coordinate="slider.x").item() == "m/s^2"
    assert data["energy"].attrs["units"] == "J"
    assert data["unit"].sel(coordinate="crank.phi").item() == "rad"
    assert data.attrs["scene"] == "driven"
    assert data.attrs["outcome"] == "OK"
    assert json.loads(data.attrs["parameters"])["J1"] == 450.0


def test_scene_without_masses_has_no_forces(make, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    machine = make("slider_crank", "bare", driven=True, masses=False)
    result = machine.kinematics([0.0, 0.5])
    assert "reaction" not in result.data
    assert "energy" not in result.data
    with pytest.raises(InputError, match="energy needs masses"):
        result.energy()
    assert result.save(tmp_path / "bare.nc").is_file()


def test_unknown_names_meet_the_nearest(result: Result) -> None:
    with pytest.raises(InputError, match=r"no coordinate 'crank\.fi'; nearest: crank\.phi"):
        result.q("crank.fi")
    with pytest.raises(InputError, match=r"'slider\.vx': it is a velocity; ask for v\("):
        result.q("slider.vx")
    with pytest.raises(InputError, match=r"no coordinate 'slider\.vxx'"):
        result.q("slider.vxx")
    with pytest.raises(AttributeError, match=r"Result has no 'outcom'; did you mean outcome"):
        _ = result.outcom
    with pytest.raises(InputError, match="joint A has no reaction 'fz'; it has fx, fy"):
        result.reaction("A", "fz")
    with pytest.raises(InputError, match="no reaction of 'guid'; nearest: guide"):
        result.reaction("guid", "fy")
    with pytest.raises(InputError, match="no power of 'crank'; nearest: crank_drive"):
        result.power("crank")
    with pytest.raises(InputError, match="no energy 'kinetics'; nearest: kinetic"):
        result.energy("kinetics")
    with pytest.raises(InputError, match=r"no series 'a\(slider\.y"):
        result.series("a(slider.yy)")


def test_series_by_any_name(result: Result) -> None:
    for name, unit in [
        ("slider.x", "m"),
        ("crank.omega", "rad/s"),
        ("a(slider.x)", "m/s^2"),
        ("A.fx", "N"),
        ("total", "J"),
        ("crank_drive", "W"),
    ]:
        values, found = result.series(name)
        assert found == unit
        assert values.shape == result.t.shape
    np.testing.assert_array_equal(result.v("slider.x"), result.v("slider.vx"))


def test_netcdf_round_trip(result: Result, tmp_path: Path) -> None:
    import xarray as xr

    path = result.save(tmp_path / "run.nc")
    with xr.open_dataset(path) as read:
        xr.testing.assert_equal(read.load(), result.data)
        assert read.attrs["message"] == result.message


def test_csv_round_trip(result: Result, tmp_path: Path) -> None:
    path = result.save(tmp_path / "run.csv")
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    column = rows[0].index("slider.x [m]")
    assert rows[0][0] == "time [s]"
    assert [float(row[column]) for row in rows[1:]] == result.q("slider.x").tolist()


def test_parquet_round_trip(result: Result, tmp_path: Path) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(result.save(tmp_path / "run.parquet"))
    assert table["crank_drive.torque [N m]"].to_pylist() == (
        result.reaction("crank_drive", "torque").tolist()
    )
    assert table.schema.metadata[b"model"] == b"sc_driven"


def test_other_endings_and_folders_are_refused(result: Result, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"saved as \.nc, \.zarr, \.csv, \.parquet, \.mat, \.html, not as '\.txt'"
    ):
        result.save(tmp_path / "run.txt")
    with pytest.raises(InputError, match="not as 'a file without ending'"):
        result.save(tmp_path / "run")
    with pytest.raises(InputError, match=r"the folder .* does not exist"):
        result.save(tmp_path / "nowhere" / "run.nc")


def test_missing_library_is_named(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"needs the library pyarrow.*save as \.csv"):
        result.save(tmp_path / "run.parquet")
    assert list(tmp_path.iterdir()) == []


def test_failed_write_leaves_the_old_file(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from runtime.results import export

    path = tmp_path / "run.csv"
    path.write_text("old")

    def fail(result: Result, path: Path) -> None:
        path.write_text("half")
        raise OSError("disk full")

    monkeypatch.setitem(export._FORMATS, ".csv", export._Format(fail))
    with pytest.raises(InputError, match=r"cannot write .*run\.csv: disk full"):
        result.save(path)
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_plot_has_a_panel_a_unit(result: Result) -> None:
    figure = result.plot("slider.x", "rod.x", "crank.omega")
    assert [axis.get_ylabel() for axis in figure.axes] == ["m", "rad/s"]
    assert len(figure.axes[0].lines) == 2
    line = figure.axes[1].lines[0]
    samples = np.searchsorted(line.get_xdata(), result.t)
    np.testing.assert_array_equal(line.get_ydata()[samples], result.v("crank.omega"))
    assert len(result.plot().axes[0].lines) == 3


def test_plot_without_matplotlib_says_what_to_install(
    result: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.delitem(sys.modules, "codegen.notebook_figure", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(InputError, match=r"pip install 'linkwright\[plot\]', in the checkout"):
        result.plot()


def test_summary_line(result: Result) -> None:
    assert repr(result).startswith("sc_driven/driven, inverse dynamics: 11 instants, t = 0 to 1 s")
