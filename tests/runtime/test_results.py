"""Results: labels, names, files whole or not at all, pictures."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from codegen.errors import InputError
from runtime.machine_facade import Machine
from runtime.results.result import Result


@pytest.fixture(scope="module")
def result(driven: Machine) -> Result:
    return driven.inverse_dynamics(np.linspace(0.0, 1.0, 11))


def test_a_frame_has_a_row_an_instant(result: Result) -> None:
    frame = result.to_pandas()
    assert len(frame) == len(result.t)
    assert frame.columns.is_unique
    np.testing.assert_array_equal(frame.index, result.t)
    np.testing.assert_array_equal(frame["A.fx"], result.reaction("A", "fx"))
    assert frame.attrs["units"]["A.fx"] == "N"
    assert frame.attrs["units"]["time"] == "s"


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


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda r: r.q("crank.fi"), r"no coordinate 'crank\.fi'; nearest: crank\.phi"),
        (lambda r: r.q("slider.vx"), r"'slider\.vx'; ask for v\('slider\.vx'\)"),
        (lambda r: r.q("slider.vxx"), r"no coordinate 'slider\.vxx'"),
        (lambda r: r.outcom, r"Result has no 'outcom'; did you mean outcome"),
        (
            lambda r: r.reaction("A", "fz"),
            r"'A' has no reaction 'fz'; ask for reaction\('A', 'fx'\)",
        ),
        (lambda r: r.reaction("guid", "fy"), "no reaction of 'guid'; nearest: guide"),
        (lambda r: r.power("crank"), "no power of 'crank'; nearest: crank_drive"),
        (lambda r: r.energy("kinetics"), "no energy 'kinetics'; nearest: kinetic"),
        (lambda r: r.series("a(slider.yy)"), r"no series 'a\(slider\.y"),
    ],
)
def test_unknown_names_meet_the_nearest(
    result: Result, ask: Callable[[Result], object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        ask(result)


@pytest.mark.parametrize(("ending", "read"), [("csv", "read_csv"), ("parquet", "read_parquet")])
def test_tables_come_back_with_the_same_bits(
    result: Result, tmp_path: Path, ending: str, read: str
) -> None:
    path = result.save(tmp_path / f"run.{ending}")
    options = {"dtype": str} if ending == "csv" else {}
    table = getattr(pd, read)(path, **options).astype(float)
    assert table.columns[0] == "time [s]"
    assert table["slider.x [m]"].tolist() == result.q("slider.x").tolist()
    torque = result.reaction("crank_drive", "torque")
    assert table["crank_drive.torque [N m]"].tolist() == torque.tolist()
    if ending == "parquet":
        import pyarrow.parquet as pq

        assert pq.read_schema(path).metadata[b"model"] == b"sc_driven"


def test_other_endings_and_folders_are_refused(result: Result, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"saved as \.nc, \.zarr, \.csv, \.parquet, \.mat, \.html, not as '\.txt'"
    ):
        result.save(tmp_path / "run.txt")
    with pytest.raises(InputError, match="not as 'a file without ending'"):
        result.save(tmp_path / "run")
    with pytest.raises(InputError, match=r"the folder .* does not exist"):
        result.save(tmp_path / "nowhere" / "run.nc")


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

    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(InputError, match=r"pip install 'linkwright\[plot\]', in the checkout"):
        result.plot()


def test_a_series_by_its_name(result: Result) -> None:
    for name in ("crank.phi", "crank.omega", "a(crank.phi)", "A.fx", "kinetic"):
        np.testing.assert_array_equal(result[name], result.series(name)[0])
    with pytest.raises(InputError, match=r"crank\.phi"):
        result["crank.fi"]


def test_a_table_to_read(result: Result) -> None:
    table = result.table("crank.phi", "A.fx", count=3)
    assert [*table.columns] == ["crank.phi [rad]", "A.fx [N]"]
    assert [*table.index] == ["0", "0.5", "1", "least", "greatest"]
    forces = result.reaction("A", "fx")
    ends = [*forces[[0, 5, 10]], forces.min(), forces.max()]
    np.testing.assert_array_equal(table["A.fx [N]"], ends)
    assert len(result.at(0.3).table()) == 3
    first = [f"{row.name} [{row.unit}]" for row in result.description.positions]
    assert [*result.table()] == first
