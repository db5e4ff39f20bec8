"""Effect rankings and work-precision studies of runs that end, or change joints, by conditions."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import pi

from codegen import Model
from codegen.errors import InputError
from runtime import load
from runtime.accuracy_target.runs import own_instants
from runtime.results.run_records import Reconnection
from runtime.studies.effect_ranking import matters
from runtime.studies.harness import Runner
from runtime.studies.reference import ReferenceSolution
from runtime.studies.work_precision import accuracy
from tests.runtime.accuracy_target.test_runs_that_end_or_reconnect import CUT, LOW, OMEGA, RISE, G


@pytest.fixture(scope="module")
def cut() -> Model:
    """A pendulum that is cut loose at 0.5 rad and lands; a light brake holds it back a little."""
    model = Model("studied_cut", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    model.torque("brake", bob, -1e-3 * bob.omega)
    model.torque("whiff", bob, -1e-9 * bob.omega)
    start, until = {bob.phi: -pi / 2, bob.omega: 7.0}, {"low": bob.y < -1.5}
    model.scene("swing", ["gravity", "brake", "whiff"], start=start, until=until)
    model.scene("plain", ["gravity"], start=start, until=until)
    return model


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ("event:hinge", CUT),
        ("event:low", LOW),
        ("bob.x", np.cos(0.5) - OMEGA * np.sin(0.5) * (LOW - CUT)),
        ("max:bob.y", np.sin(0.5) + RISE**2 / (2 * G)),
        ("count:hinge", 1.0),
        ("max:bob.omega", 7.0),
    ],
)
def test_a_ranking_of_a_machine_that_is_cut_loose(
    cut: Model, tmp_path_factory: pytest.TempPathFactory, asked: str, expected: float
) -> None:
    folder = tmp_path_factory.getbasetemp() / "ranked_cut"
    folder.mkdir(exist_ok=True)
    found = matters(
        cut, "swing", asked=asked, t_end=3.0, points=101, rounds=1, error=1e-6, folder=folder
    )
    free = load(cut, "plain", folder=folder).simulate(3.0, rtol=1e-12)
    assert free.ended_by == "low"
    brake, whiff, gravity = (found[name] for name in ("brake", "whiff", "gravity"))
    assert_allclose(brake.value, expected, rtol=2e-8)
    assert whiff.verdict in {"negligible", "none seen"}
    assert gravity.verdict == "needed"
    other = "0 events" if asked == "event:low" else "where the full scene ends where 'low' begins"
    assert other in gravity.reason
    assert found.doubt <= 1e-6 * abs(expected)
    if asked in {"event:hinge", "event:low", "bob.x", "max:bob.y"}:
        assert brake.relative > 1e-6
        assert found.proposal.left_out == ("whiff",)


def test_a_quantity_that_jumps_where_joints_engage(tmp_path: Path) -> None:
    """The largest speed is that just before the catch, which no even instant meets."""
    model = Model("studied_catch")
    cart, load_ = (model.particle(name, mass=m) for name, m in (("cart", 2.0), ("load", 1.0)))
    for particle in (cart, load_):
        model.absolute(f"rail_{particle.name}", particle, "y", 0.0)
    hook = model.constraint("hook", load_.x - cart.x)
    model.engage(hook, when=cart.x > load_.x)
    model.force("push", cart, fx=2.0)
    model.force("air", load_, fx=-1e-6 * load_.vx)
    start = {cart.x: 0.0, cart.vx: 3.0, load_.x: 1.0, load_.vx: 0.0}
    model.scene("meet", ["push", "air"], start=start)
    met = (np.sqrt(11.0) - 3.0) * 1.0  # 3 t + t²/2 = 1
    peak = 3.0 + met
    found = matters(model, asked="max:cart.vx", t_end=0.8, points=11, rounds=1, folder=tmp_path)
    assert_allclose(found.value, peak, rtol=1e-6)
    found = matters(model, asked="cart.vx", t_end=0.8, points=11, rounds=1, folder=tmp_path)
    assert_allclose(found["air"].value, 2 / 3 * peak + 2 / 3 * (0.8 - met), rtol=1e-8)
    with pytest.raises(InputError, match="hook"):
        matters(model, asked="event:hok", t_end=0.8, points=11, rounds=1, folder=tmp_path)


@pytest.mark.parametrize("quantities", [(), ("bob.x", "kinetic")])
def test_work_and_precision(cut: Model, tmp_path: Path, quantities: tuple[str, ...]) -> None:
    study = accuracy(
        cut, "plain", t_end=3.0, quick=True, points=40, quantities=quantities,
        methods=("dop853", "dopri5"), formulations=("cartesian",), modelling=False,
        folder=tmp_path,
    )  # fmt: skip
    assert study.t_end == pytest.approx(LOW, abs=1e-10)
    assert study.reference.floor < 1e-10
    assert [scale.name for scale in study.quantities][-2:] == ["t(hinge)", "t(low)"]
    for line in study.lines:
        points = [point for point in line.points if point.errors is not None]
        assert len(points) == 4
        assert points[-1].worst < 1e-6
        each = points[-1].errors.each
        assert max(each["t(hinge)"], each["t(low)"]) < 1e-6
        assert points[0].errors.each["t(low)"] > 0.0
        assert points[0].worst > points[-1].worst


def test_a_reference_from_a_file(cut: Model, tmp_path: Path) -> None:
    t = np.linspace(0.4, 2.0, 33)
    x = np.cos(0.5) - OMEGA * np.sin(0.5) * (t - CUT)
    rows = "\n".join(f"{a!r},{b!r}" for a, b in zip(t.tolist(), x.tolist(), strict=True))
    file = tmp_path / "flight.csv"
    file.write_text(f"t,bob.x\n{rows}\n")
    study = accuracy(
        cut, "plain", quick=True, reference=file, methods=("dop853",),
        formulations=("cartesian",), modelling=False, folder=tmp_path,
    )  # fmt: skip
    assert study.reference.independent
    assert study.reference.floor < 1e-10
    assert study.t_end == pytest.approx(t[t < LOW][-1])
    assert study.lines[0].points[-1].worst < 1e-7


def test_names_of_instants() -> None:
    changes = [Reconnection(time, "pin", "release", {}, 0.0, {}) for time in (1.0, 3.0)]
    changes.insert(1, Reconnection(2.0, "slot", "engage", {}, 0.0, {}))
    run = SimpleNamespace(reconnections=changes, ended_by="home", t=[0.0, 4.0])
    instants = {"t(pin)": 1.0, "t(slot)": 2.0, "t(pin)#2": 3.0, "t(home)": 4.0}
    assert own_instants(run) == instants
    run.reconnections, run.ended_by = (), ""
    assert own_instants(run) == {}


def test_runs_with_other_ends_are_told_apart(cut: Model, tmp_path: Path) -> None:
    machine = load(cut, "plain", folder=tmp_path)
    whole, short = (machine.simulate(end, 31) for end in (3.0, 1.0))
    runner = Runner(machine, machine.assemble(), whole.t, 60.0, 10**6)
    compared = ReferenceSolution(runner, whole, ())
    assert compared.difference(whole) == ""
    assert "t(hinge), and those of the reference t(hinge), t(low)" in compared.difference(short)
    assert compared.own == ("t(hinge)", "t(low)")
    assert_allclose(compared.values(whole)[0], [CUT, LOW], atol=1e-6)
    late = machine.simulate(3.0, 31, rtol=1e-3)
    assert compared.rows(late)[-1] == len(late.t) - 1
