"""Machines with redundant joints beside the same ones without: one motion, at one speed.

A third crank that stands off the line of the others, in a linkage that stands askew: its pin is
held by two constraints, of which one is new, and no fixed one of them is so all the way round. A
four-bar with a second coupler, with a double pin, with welds in a ring. Two tables welded together,
each on its own cranks, which leave one direction of three, and that turns.
"""

import pickle
from collections.abc import Callable
from math import acos, atan2, cos, hypot, pi, sin
from pathlib import Path

import numpy as np
import pytest

from codegen import Model, t
from codegen.check.kinematics import examine
from codegen.check.shared_rows import shared_rows
from codegen.derive.equations import derive
from codegen.errors import AnalysisError
from codegen.explain.ledger import explain
from codegen.lower.kernels.independent_rows import SharedRows
from codegen.lower.lowered_scene import outline
from models.hard.parallel_linkage import parallel_linkage
from runtime import Machine, Outcome, Result, load
from runtime.mechanism.dense_equations import Equations

CRANK, COUPLER, ROCKER, GROUND = 1.0, 3.0, 2.5, 3.2
ROUND = np.linspace(0.0, 3.0, 61)


def askew(*, redundant: bool) -> Model:
    """A table on three cranks, whose pins stand on no line; the third need not reach it."""
    model = Model(f"askew_{redundant}", gravity=(0, -9.81))
    pins = [(-0.7, -0.7), (0.7, 0.7), (-0.5, 0.5)]
    table = model.body("table", mass=5.0, inertia=2.0)
    bars = [model.body(f"crank_{k}", mass=1.0, inertia=1 / 12) for k in range(3)]
    drawn = {table.x: cos(1.0), table.y: sin(1.0), table.phi: 0.0}
    for k, (bar, pin) in enumerate(zip(bars, pins, strict=True)):
        model.revolute(f"A{k}", model.ground.at(*pin), bar.at(-0.5, 0))
        if k < 2 or redundant:
            model.revolute(f"B{k}", bar.at(0.5, 0), table.at(*pin))
        else:
            model.constraint("along", bar.phi - bars[0].phi)
        drawn |= {bar.x: pin[0] + cos(1.0) / 2, bar.y: pin[1] + sin(1.0) / 2, bar.phi: 1.0}
    model.driver("drive", bars[0].phi, 1.0 + 2 * pi * t)
    free = {name: value for name, value in drawn.items() if name is not bars[0].phi}
    model.scene("run", ["gravity"], start={bars[0].phi: 1.0, bars[0].omega: 8.0}, guess=free)
    model.scene("driven", ["gravity"], ["drive"], guess=drawn)
    return model


def four_bar(extra: str = "", *, redundant: bool = False) -> Model:
    """A crank-rocker; `extra`: a second coupler, a double pin, or two bodies welded in a ring."""
    model = Model(f"four_bar_{extra or 'plain'}_{redundant}", gravity=(0, -9.81))
    ax, ay = CRANK * cos(1.0), CRANK * sin(1.0)
    far = hypot(GROUND - ax, -ay)
    beta = acos((COUPLER**2 + far**2 - ROCKER**2) / (2 * COUPLER * far)) + atan2(-ay, GROUND - ax)
    bx, by = ax + COUPLER * cos(beta), ay + COUPLER * sin(beta)
    crank = model.body("crank", mass=1, inertia=0.1)
    coupler = model.body("coupler", mass=2, inertia=1.5)
    rocker = model.body("rocker", mass=1.5, inertia=0.8)
    model.revolute("O", model.ground.at(0, 0), crank.at(-CRANK / 2, 0))
    model.revolute("A", crank.at(CRANK / 2, 0), coupler.at(-COUPLER / 2, 0))
    model.revolute("B", coupler.at(COUPLER / 2, 0), rocker.at(ROCKER / 2, 0))
    model.revolute("C", model.ground.at(GROUND, 0), rocker.at(-ROCKER / 2, 0))
    guess = {crank.x: ax / 2, crank.y: ay / 2}
    middle = {"x": (ax + bx) / 2, "y": (ay + by) / 2, "phi": beta}
    guess |= {getattr(coupler, name): value for name, value in middle.items()}
    guess |= {rocker.x: (bx + GROUND) / 2, rocker.y: by / 2, rocker.phi: atan2(by, bx - GROUND)}
    if extra == "coupler":
        second = model.body("second", mass=1, inertia=0.7)
        model.revolute("D", crank.at(CRANK / 2, 0), second.at(-COUPLER / 2, 0))
        if redundant:
            model.revolute("E", second.at(COUPLER / 2, 0), rocker.at(ROCKER / 2, 0))
        else:
            model.constraint("same", second.phi - coupler.phi)
        guess |= {getattr(second, name): value for name, value in middle.items()}
    if extra == "pin" and redundant:
        model.revolute("B2", coupler.at(COUPLER / 2, 0), rocker.at(ROCKER / 2, 0))
    if extra == "ring":
        one, other = (model.body(name, mass=1, inertia=0.5) for name in ("one", "other"))
        model.weld("W1", coupler.at(0, 0), one.at(0, -0.3))
        model.weld("W2", one.at(0.3, 0), other.at(0, 0))
        if redundant:
            model.weld("W3", other.at(-0.3, 0.3), coupler.at(0, 0.6))
        for body in (one, other):
            guess |= {getattr(body, name): value for name, value in middle.items()}
    model.scene("run", ["gravity"], start={crank.phi: 1.0, crank.omega: 3.0}, guess=guess)
    return model


def two_tables(*, redundant: bool, engaging: bool = False) -> Model:
    """Two tables, each on two cranks of its own, welded together, or later, or turned together."""
    model = Model(f"two_tables_{redundant}_{engaging}", gravity=(0, -9.81))
    guess, tables, leading = {}, [], []
    for side, x in (("left", 0.0), ("right", 5.0)):
        table = model.body(f"{side}_table", mass=2.0, inertia=1.0)
        guess |= {table.x: x + cos(1.0), table.y: sin(1.0)}
        for k in range(2):
            bar = model.body(f"{side}_{k}", mass=1.0, inertia=0.1)
            model.revolute(f"{side}_A{k}", model.ground.at(x + k, 0.3 * k), bar.at(-0.5, 0))
            model.revolute(f"{side}_B{k}", bar.at(0.5, 0), table.at(k, 0.3 * k))
            guess |= {bar.x: x + k + cos(1.0) / 2, bar.y: 0.3 * k + sin(1.0) / 2, bar.phi: 1.0}
            leading += [bar] if k == 0 else []
        tables.append(table)
    if redundant:
        model.weld("W", tables[0].at(2.5, 0), tables[1].at(-2.5, 0))
    else:
        model.constraint("along", leading[1].phi - leading[0].phi)
    if engaging:
        model.engage("W", when=t > 0.3)
    fixed = leading if engaging else leading[:1]
    start = {name: value for bar in fixed for name, value in ((bar.phi, 1.0), (bar.omega, 8.0))}
    guess = {name: value for name, value in guess.items() if name not in start}
    model.scene("run", ["gravity"], start=start, guess=guess)
    return model


MACHINES: dict[str, Callable[[bool], Model]] = {
    "askew": lambda redundant: askew(redundant=redundant),
    "coupler": lambda redundant: four_bar("coupler", redundant=redundant),
    "pin": lambda redundant: four_bar("pin", redundant=redundant),
    "ring": lambda redundant: four_bar("ring", redundant=redundant),
    "two_tables": lambda redundant: two_tables(redundant=redundant),
}
NAMED = {
    "askew": "B2.y", "coupler": "E.y", "pin": "B2.x, B2.y", "ring": "W3.x, W3.y, W3.angle",
    "two_tables": "W.y, W.angle",
}  # fmt: skip


@pytest.fixture(scope="module", params=MACHINES)
def pair(request: pytest.FixtureRequest) -> tuple[str, Machine, Machine]:
    """A machine with redundant constraints, and the same without."""
    folder: Path = request.config.cache.mkdir("independent-rows")
    both = (load(MACHINES[request.param](is_so), "run", folder=folder) for is_so in (True, False))
    return request.param, *both


def operations(machine: Machine) -> dict[str, int]:
    return dict(machine.mechanism.description.operations)


def assert_alike(one: Result, other: Result, within: float) -> None:
    assert one.outcome is other.outcome is Outcome.OK, one.message + other.message
    common = {*one.description.coordinates.names} & {*other.description.coordinates.names}
    for name in common:
        np.testing.assert_allclose(one.q(name), other.q(name), rtol=0, atol=within)


@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_it_moves_as_without_redundant_rows(
    pair: tuple[str, Machine, Machine], method: str
) -> None:
    name, machine, plain = pair
    words = {"method": method, "rtol": 1e-11, "atol": 1e-12, "progress": False}
    run, other = (one.simulate(3.0, ROUND, **words) for one in (machine, plain))
    assert_alike(run, other, 1e-9 if method == "dop853" else 2e-8)
    assert run.samples.residual[:, 0].max() < 1e-12
    if name == "askew":  # the third crank leads the others past the line of their pins
        assert other.singular
        assert not run.singular
    else:
        assert len(run.singular) == len(other.singular)
        assert run.stats["steps"] == pytest.approx(other.stats["steps"], rel=0.1, abs=3)
    assert f"Redundant: {NAMED[name]}; the reactions of" in run.message
    assert np.isfinite(run.samples.reaction).all()


def test_it_moves_so_in_reduced_coordinates(pair: tuple[str, Machine, Machine]) -> None:
    _, machine, plain = pair
    words = {"formulation": "reduced", "rtol": 1e-11, "progress": False}
    run, other = (one.simulate(3.0, ROUND, **words) for one in (machine, plain))
    assert_alike(run, other, 1e-8)


def test_whole_joints_that_repeat_others_cost_nothing(pair: tuple[str, Machine, Machine]) -> None:
    name, machine, plain = pair
    here, there = operations(machine), operations(plain)
    for kernel in ("accelerations", "correction"):
        most = 1.0 if name in ("pin", "ring") else 2.0
        assert there[kernel] <= here[kernel] <= most * there[kernel]


def test_reactions_are_those_of_least_norm(pair: tuple[str, Machine, Machine]) -> None:
    """No multipliers that exert no force are among them."""
    _, machine, _ = pair
    run = machine.simulate(1.0, 11, rtol=1e-10, progress=False)
    equations = Equations(machine.mechanism, machine.parameter_values(run.parameters))
    redundant = len(machine.mechanism.description.redundant)
    for time, q, lam in zip(run.t, run.samples.q, run.samples.lam, strict=True):
        free = np.linalg.svd(equations.jacobian(time, q))[0][:, equations.m - redundant :]
        assert np.abs(free.T @ lam).max() < 1e-8 * np.abs(lam).max()


def test_a_driven_one_passes_where_a_fixed_choice_of_rows_would_lock(tmp_path: Path) -> None:
    """The third crank is level after a part of the turn, and upright; neither is singular."""
    machine = load(askew(redundant=True), "driven", folder=tmp_path)
    run = machine.inverse_dynamics(np.linspace(0.0, 1.0, 101))
    assert run.outcome is Outcome.OK, run.message
    for k in range(3):
        np.testing.assert_allclose(run.q(f"crank_{k}.phi"), 1.0 + 2 * pi * run.t, atol=1e-11)
    assert not run.singular  # nor where the line of the first two pins lies along the cranks
    torque = run.reaction("drive", "torque")
    np.testing.assert_allclose(torque, 9.81 * 6.5 * np.cos(1.0 + 2 * pi * run.t), atol=1e-7)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_poor_choice_passes_where_it_is_singular(
    method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One row of the last pin says nothing twice a turn: the run crosses, as a dead centre."""
    words = {"method": method, "rtol": 1e-10, "max_steps": 3000, "progress": False}
    good = load(askew(redundant=True), "run", folder=tmp_path / "good")
    other = good.simulate(1.0, 21, **words)
    poor = (SharedRows((10, 11), (11,), (10,), ()),)
    monkeypatch.setattr("codegen.driver.shared_rows", lambda *_: poor)
    run = load(askew(redundant=True), "run", folder=tmp_path / "poor").simulate(1.0, 21, **words)
    assert run.singular
    assert_alike(run, other, 1e-7)


@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_couplers_that_share_a_crank_turn_through(method: str, tmp_path: Path) -> None:
    """Two tables on three cranks each, one in common, with pins off one line: 22 rows on 21."""
    pins = [(-0.7, -0.7), (0.7, 0.7), (-0.5, 0.5), (0.6, -0.4), (0.1, 0.9)]
    model, drawn = Model("shared_crank", gravity=(0, -9.81)), {}
    bars = [model.body(f"crank_{k}", mass=1.0, inertia=1 / 12) for k in range(5)]
    for k, (bar, (x, y)) in enumerate(zip(bars, pins, strict=True)):
        model.revolute(f"A{k}", model.ground.at(x, y), bar.at(-0.5, 0))
        drawn |= {bar.x: x + cos(1.0) / 2, bar.y: y + sin(1.0) / 2, bar.phi: 1.0}
    for j, held in enumerate([(0, 1, 2), (2, 3, 4)]):
        table = model.body(f"table_{j}", mass=3.0, inertia=1.0)
        drawn |= {table.x: cos(1.0), table.y: sin(1.0), table.phi: 0.0}
        for k in held:
            model.revolute(f"B{j}{k}", bars[k].at(0.5, 0), table.at(*pins[k]))
    angle = drawn.pop(bars[0].phi)
    model.scene("run", ["gravity"], start={bars[0].phi: angle, bars[0].omega: 8.0}, guess=drawn)
    run = load(model, "run", folder=tmp_path).simulate(
        1.5, 31, method=method, rtol=1e-9, progress=False
    )
    assert run.outcome is Outcome.OK, run.message
    assert not run.singular
    assert "Redundant: B02.y, B14.y" in run.message
    angles = np.array([run.q(f"crank_{k}.phi") for k in range(5)])
    assert np.ptp(angles[0]) > 4 * pi
    np.testing.assert_allclose(angles, angles[:1].repeat(5, axis=0), rtol=0, atol=1e-12)
    # 5/3 kg m² of the cranks about their pivots, 6 kg m² of the tables; 8.5 kg m of weight
    energy = 23 / 6 * run.v("crank_0.omega") ** 2 + 8.5 * 9.81 * np.sin(angles[0])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_it_strikes_a_stop_as_without_redundant_rows(tmp_path: Path, method: str) -> None:
    runs = []
    for redundant in (True, False):
        model = askew(redundant=redundant)
        model.contact("stop", gap=model.bodies["table"].y + 0.2, restitution=0.5)
        crank, guess = model.bodies["crank_0"], dict(model.scenes["run"].guess)
        model.scene("hit", ["gravity", "stop"], start={crank.phi: 1.0}, guess=guess)
        words = {"method": method, "rtol": 1e-10, "progress": False}
        runs.append(load(model, "hit", folder=tmp_path).simulate(1.5, 16, **words))
    assert_alike(*runs, 1e-9)
    times, others = ([event.time for event in run.events] for run in runs)
    np.testing.assert_allclose(times, others, rtol=1e-9)
    assert len(times) > 5


def test_a_joint_that_engages_may_be_redundant(tmp_path: Path) -> None:
    """Tables that move alike are welded in the run: only what is said of reactions changes."""
    joined = load(two_tables(redundant=True, engaging=True), "run", folder=tmp_path)
    plain = load(two_tables(redundant=False), "run", folder=tmp_path)
    run, other = (one.simulate(1.0, 21, rtol=1e-10, progress=False) for one in (joined, plain))
    assert_alike(run, other, 1e-9)
    assert "Redundant: W.y, W.angle" in run.message


def test_ensembles_are_the_single_runs(tmp_path: Path) -> None:
    machine = load(askew(redundant=True), "run", folder=tmp_path)
    speeds = np.array([7.0, 8.0])
    found = machine.ensemble(0.5, 6, starts={"crank_0.omega": speeds}, progress=False)
    for k, speed in enumerate(speeds.tolist()):
        run = machine.simulate(0.5, 6, start={"crank_0.omega": speed}, progress=False)
        assert (found["q"].sel(coordinate="table.x").values[k] == run.q("table.x")).all()
        held = found["reaction"].sel(joint="B2", component="fy").values[k]
        assert (held == run.reaction("B2", "fy")).all()


def test_reactions_stay_least_while_a_brake_holds(tmp_path: Path) -> None:
    """Friction that sticks mixes two kernels' answers; a choice of its own would jump there."""
    model = parallel_linkage(3)
    crank = model.bodies["crank_0"]
    model.dry_friction("brake", slip=crank.omega, normal=1000.0, coefficient=0.3)
    fall = model.scenes["fall"]
    model.scene("held", ["gravity", "brake"], start=dict(fall.start), guess=dict(fall.guess))
    machine = load(model, "held", folder=tmp_path)
    run = machine.simulate(0.1, 5, progress=False)
    assert (run.samples.modes == 2).any()
    equations = Equations(machine.mechanism, machine.parameter_values(run.parameters))
    for q, lam in zip(run.samples.q, run.samples.lam, strict=True):
        free = np.linalg.svd(equations.jacobian(0.0, q))[0][:, -1]
        assert abs(free @ lam) < 1e-8 * np.abs(lam).max()


def chosen(model: Model, scene: str) -> tuple[SharedRows, list[str]]:
    """What is left of the joints with redundant rows, and the coordinates of its columns."""
    equations = derive(model, model.scenes[scene])
    drawn = outline(equations)
    (joint,) = shared_rows(drawn, examine(model, equations, drawn).dependent)
    return joint, [drawn.scene.names[k] for k in joint.columns]


def test_the_direction_that_is_left_is_that_of_a_crank() -> None:
    """Its angle's column turns with it; of welded tables that of one of the cranks below."""
    joint, columns = chosen(parallel_linkage(3), "fall")
    assert joint == SharedRows((10, 11), (11,), (), (11,))
    assert columns == ["crank_2_phi"]
    joint, (column,) = chosen(two_tables(redundant=True), "run")
    assert (len(joint.rows), len(joint.redundant)) == (3, 2)
    assert column.endswith("_phi")


@pytest.mark.parametrize("scene", ["run", "driven"])
def test_loops_that_hold_each_other_past_a_change_point_are_taken_together(scene: str) -> None:
    """Pins off one line: where two cranks lie along theirs, the third alone tells the way."""
    joint, columns = chosen(askew(redundant=True), scene)
    assert joint.rows == (6, 7, 10, 11)
    assert (joint.redundant, joint.kept) == ((11,), ())
    assert len(columns) == 3
    assert "table_phi" in columns


def test_a_row_that_never_changes_stays_as_it_is() -> None:
    """Of a weld of two sliders on guides of one direction the row along them."""
    model = Model("sliders")
    bodies = [model.body(name, mass=1.0, inertia=0.1) for name in ("one", "other")]
    for body in bodies:
        model.translational(f"{body.name}_guide", model.ground, body, axis=(1, 0))
    model.weld("W", bodies[0].at(1, 0), bodies[1].at(-1, 0))
    model.scene("run", [], start={bodies[0].x: 0.0})
    assert chosen(model, "run") == (SharedRows((4, 5, 6), (5, 6), (4,), ()), [])


def test_other_redundancy_than_the_build_saw_is_refused(tmp_path: Path) -> None:
    """Built with a last crank that is too long, the module takes all joints for independent."""
    model = parallel_linkage(3)
    long = model.scenes["fall"].with_(parameters={"last": 1.3})
    machine = load(model, long, folder=tmp_path)
    with pytest.raises(AnalysisError) as caught:
        machine.simulate(1.0, parameters={"last": 1.0})
    text = str(caught.value)
    assert "B2.y follows from others, and with those that the module was built with no" in text
    assert "Load scene.with_(parameters=..., guess=...) with the values of this run" in text
    alike = load(model, long.with_(parameters={"last": 1.0}), folder=tmp_path)
    assert alike.simulate(0.1, progress=False).outcome is Outcome.OK


@pytest.mark.parametrize("words", [{}, {"method": "radau5"}, {"formulation": "reduced"}])
def test_rows_that_cease_to_agree_contradict_the_run(tmp_path: Path, words: dict[str, str]) -> None:
    """A law that starts as the joints do, with its first three rates, and leaves them later."""
    model = askew(redundant=True)
    first, last = (model.bodies[f"crank_{k}"] for k in (0, 2))
    model.constraint("law", last.phi - first.phi - 0.01 * t**4)
    run = load(model, "run", folder=tmp_path).simulate(1.0, 11, progress=False, **words)
    assert run.outcome is Outcome.CONTRADICTED
    assert "law.row" in run.message


def test_its_ledger_counts_the_kernels_of_the_module(pair: tuple[str, Machine, Machine]) -> None:
    name, machine, _ = pair
    (ledger,) = explain(MACHINES[name](True), "run")
    counted = operations(machine)
    assert counted == {kernel: ledger.totals.get(kernel, 0) for kernel in counted}


def test_a_pickled_machine_keeps_its_rows_and_kernels_together(
    pair: tuple[str, Machine, Machine],
) -> None:
    mechanism = pair[1].mechanism
    again = pickle.loads(pickle.dumps(mechanism.with_independent_rows))
    rows = mechanism.description.independent_jacobian_rows
    assert (again.description.jacobian_rows == rows).all()
    assert (again.whole.description.jacobian_rows == mechanism.description.jacobian_rows).all()


def test_an_independent_machine_has_nothing_of_it(pair: tuple[str, Machine, Machine]) -> None:
    _, machine, plain = pair
    assert plain.mechanism.description.redundant == ()
    assert not [name for name in operations(plain) if "independent" in name or "free" in name]
    assert "independent_jacobian" in operations(machine)
