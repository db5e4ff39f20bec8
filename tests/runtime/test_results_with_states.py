"""States, sampled values and latches in results, files, texts, studies and start values."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from codegen.errors import AssemblyError, InputError
from linkwright.cli.application import app
from runtime import load, matters
from runtime.machine_facade import Machine
from runtime.results.result import Result

DECLARED = """
from codegen import Model, t
model = Model("drive")
rotor = model.body("rotor", mass=1.0, inertia=0.002)
model.revolute("shaft", model.ground.at(0, 0), rotor.at(0, 0))
u = model.sampled("u", 0.05, 12 + 0.1 * (40 - rotor.omega), unit="V")
current = model.state("current", lambda i: (u - 2 * i - 0.1 * rotor.omega) / 0.01, 1.0, "A")
fast = model.latch("fast", when=rotor.omega > 30)
model.torque("drive", on=rotor, value=0.1 * current)
model.torque("drag", on=rotor, value=-0.001 * rotor.omega)
model.torque("brake", on=rotor, value=-0.05, when=fast)
model.scene("spin", ["drive", "drag", "brake"], start={rotor.phi: 0.0, rotor.omega: 0.0})
model.scene("coast", ["drag"], start={rotor.phi: 0.0, rotor.omega: 10.0})
model.driver("turn", rotor.phi, 20 * t)
model.scene("driven", ["drive"], drivers=["turn"])
"""
STATES = ("u", "current", "fast")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drive") / "drive.py"
    path.write_text(DECLARED, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def drive(file: Path) -> Machine:
    return load(file, scene="spin", folder=file.parent)


@pytest.fixture(scope="module")
def run(drive: Machine) -> Result:
    return drive.simulate(0.5, 101, rtol=1e-9)


def test_states_by_name(drive: Machine, run: Result) -> None:
    assert drive.states.names == STATES
    assert drive.states["current"].unit == "A"
    (kept,) = 12 + 0.1 * (40 - run.at(0.05).v("rotor.omega"))
    assert_allclose(run.y("u")[11:20], kept, rtol=1e-9)
    assert {*run.y("fast")} == {0.0, 1.0}
    slope = (run.y("u") - 2 * run.y("current") - 0.1 * run.v("rotor.omega")) / 0.01
    assert_allclose(run.a("current")[1:], slope[1:], rtol=1e-6, atol=1e-5)
    assert run.series("current")[1] == "A"
    assert run.series("a(current)")[1] == "A/s"
    assert run.state(0.2)["current"] == run.at(0.2).y("current")[0]
    with pytest.raises(InputError, match="no state 'curent'; nearest: current"):
        run.y("curent")
    with pytest.raises(InputError, match=r"no coordinate 'current'; ask for y\('current'\)"):
        run.q("current")


def test_tables_have_states_and_not_their_integrals(run: Result, tmp_path: Path) -> None:
    data = run.data
    assert data["y"].sel(state="current").values.tolist() == run.y("current").tolist()
    assert data["state_unit"].values.tolist() == ["V", "A", "1"]
    assert data["coordinate"].values.tolist() == ["rotor.x", "rotor.y", "rotor.phi"]
    assert {*data["velocity_unit"].values} == {"m/s", "rad/s"}
    run.save(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8") as text:
        rows = [*csv.reader(text)]
    assert {"current [A]", "u [V]", "fast [1]"} <= {*rows[0]}
    assert_allclose(float(rows[-1][rows[0].index("current [A]")]), run.y("current")[-1])
    from runtime.show.html_report import page
    from tests.runtime.show.page_data import header_of

    report = page(run)
    tables = report[report.index("<article") : report.index("</article>")]
    texts = [",".join(rows[0]), *map(str, data.coords.values()), tables, repr(run)]
    texts += [
        str(header_of(report)["runs"][0]["series"]),
        str(header_of(report)["runs"][0]["groups"]),
    ]
    texts += [run._repr_html_(), *(axis.get_ylabel() for axis in run.plot("current", "u").axes)]
    assert not any("integral" in text or ".value" in text for text in texts)
    assert texts[-2:] == ["A", "V"]
    assert "states       u (V), current (A), fast (1)" in repr(run)


def test_texts_do_not_count_states_as_freedom(drive: Machine) -> None:
    begin = drive.assemble()
    assert (begin.degrees_of_freedom, drive.degrees_of_freedom) == (1, 1)
    assert "degrees of freedom: 1, states: 3;" in str(begin)
    assert "\n  y  u = 0 V, current = 1 A, fast = 0 1" in repr(begin)
    assert "integral" not in repr(begin) + begin._repr_html_()
    text = drive.path.read_text(encoding="utf-8")
    assert "3 coordinates, 2 constraints, 1 degree of freedom, 3 states." in text
    assert "3 coordinates" in repr(drive)
    assert "states      u, current, fast" in repr(drive)


def test_start_values_and_guesses(drive: Machine) -> None:
    r = drive.simulate(0.1, [0.0, 0.1], start={"current": 3.0, "u": 2.0})
    assert r.y("current")[0] == 3.0
    assert "start sets current = 3 A, u = 2 V" in r.message
    with pytest.raises(AssemblyError, match=r"guess names what the scene fixes: u = 0 V\."):
        drive.simulate(0.1, guess={"u": 2.0})
    with pytest.raises(AssemblyError, match="velocity or state 'curent'; nearest: current"):
        drive.simulate(0.1, start={"curent": 3.0})


def test_the_command_line(file: Path, drive: Machine) -> None:
    words = ["simulate", str(file), "--scene", "spin", "--t-end", "0.1", "--start", "current=3"]
    words += ["--generated", str(drive.path.parent)]
    answer = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)
    r = drive.simulate(0.1, start={"current": 3.0})
    assert [*answer["q"], *answer["v"], *answer["y"]] == [
        "rotor.x", "rotor.y", "rotor.phi", "rotor.vx", "rotor.vy", "rotor.omega", *STATES
    ]  # fmt: skip
    assert_allclose(answer["y"]["current"], r.y("current")[-1], rtol=1e-6)
    shown = CliRunner().invoke(app, words).stdout
    assert any(line.split()[::2] == ["current", "A"] for line in shown.splitlines())


def test_quantities_of_studies(drive: Machine, file: Path) -> None:
    r = drive.simulate(0.3, accuracy=1e-6, quantities=["current", "rotor.phi"])
    assert r.accuracy is not None
    assert {one.name for one in r.accuracy.quantities} == {"current", "rotor.phi"}
    fine = drive.simulate(0.3, rtol=1e-12)
    assert_allclose(r.y("current"), fine.y("current"), atol=1e-5)
    whole = drive.simulate(0.3, accuracy=1e-6)
    assert whole.accuracy is not None
    assert not [q for q in whole.accuracy.quantities if "integral" in q.name]
    found = matters(str(file), asked="max:current", scene="spin", t_end=0.3, folder=file.parent)
    assert {row.name for row in found.rows} >= {"drag", "brake"}


def test_a_driven_machine_with_states_is_simulated(file: Path) -> None:
    driven = load(file, scene="driven", folder=file.parent)
    assert (driven.degrees_of_freedom, driven.is_determined) == (0, False)
    r = driven.simulate(0.2, rtol=1e-10)
    assert "Nothing was left" not in r.message
    u = 12 + 0.1 * (40 - 20.0)
    final = (u - 0.1 * 20.0) / 2
    assert_allclose(r.y("current"), final + (1 - final) * np.exp(-200 * r.t), atol=1e-8)
