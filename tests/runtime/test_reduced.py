"""Runs in reduced coordinates: the same results under the same names, and what they refuse."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from codegen.errors import AnalysisError, InputError
from codegen.generated_files.generated_file import write_if_changed
from linkwright.cli.application import app
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import _mobility
from runtime.machine_facade import Machine
from runtime.results.result import Result

TIGHT = 1e-12
SAME = 1e-10


Library = Callable[[str, str], Machine]


@pytest.fixture(scope="module")
def compressor(library: Library) -> Machine:
    return library("slider_crank", "compressor")


@pytest.fixture(scope="module")
def parallelogram(library: Library) -> Machine:
    return library("hard/n_four_bar", "fall")


def both(machine: Machine, t_end: float, **options: object) -> tuple[Result, Result]:
    t = np.linspace(0.0, t_end, 41)
    given = {"rtol": TIGHT, "progress": False, **options}
    whole = machine.simulate(t_end, t, **given)
    return whole, machine.simulate(t_end, t, formulation="reduced", **given)


def assert_same(machine: Machine, whole: Result, less: Result, within: float = SAME) -> None:
    assert (whole.outcome, less.outcome) == (Outcome.OK, Outcome.OK)
    for row in machine.coordinates:
        for ask in (lambda r, n=row.name: r.q(n), lambda r, n=row.velocity: r.v(n)):
            theirs, ours = ask(whole), ask(less)
            assert_allclose(ours, theirs, rtol=0, atol=within * max(1.0, np.abs(theirs).max()))


# The same results


def test_a_run_with_events(compressor: Machine) -> None:
    whole, less = both(compressor, 1.0)
    assert_same(compressor, whole, less)
    assert len(whole.events) > 10
    for theirs, ours in zip(whole.events, less.events, strict=True):
        assert (ours.name, ours.direction) == (theirs.name, theirs.direction)
        assert ours.time == pytest.approx(theirs.time, abs=1e-11)
        assert_allclose(ours.q, theirs.q, rtol=1e-9, atol=1e-9)
        assert_allclose(ours.v, theirs.v, rtol=1e-8, atol=1e-8)
    for joint, component in (("A", "fx"), ("B", "fy")):
        theirs = whole.reaction(joint, component)
        atol = 1e-8 * np.abs(theirs).max()
        assert_allclose(less.reaction(joint, component), theirs, rtol=0, atol=atol)
    assert_allclose(less.energy(), whole.energy(), rtol=1e-9)
    assert_allclose(less.power("gas"), whole.power("gas"), rtol=1e-6, atol=1e-3)
    assert less.stats["corrections"] == 0


def test_constraints_that_are_left(library: Library) -> None:
    machine = library("gear_slider", "train_running")
    assert machine.mechanism.reduced.closures
    assert_same(machine, *both(machine, 0.5))


def test_rigid_contact_that_bounces(library: Library) -> None:
    machine = library("hard/contact_follower", "touching")
    whole, less = both(machine, 0.5)
    assert_same(machine, whole, less, 1e-9)


def test_friction_from_reactions(library: Library) -> None:
    machine = library("hard/guide_friction", "creeping")
    assert_same(machine, *both(machine, 0.5))


@pytest.mark.parametrize("method", ["dopri5", "radau5", "bdf", "auto"])
def test_every_method(compressor: Machine, method: str) -> None:
    rtol = 1e-8
    whole = compressor.simulate(0.2, rtol=TIGHT, progress=False)
    less = compressor.simulate(0.2, rtol=rtol, method=method, formulation="reduced", progress=False)
    last = [result.q("crank.phi")[-1] for result in (whole, less)]
    assert last[1] == pytest.approx(last[0], abs=1e-4)
    assert less.outcome is Outcome.OK


def test_whole_turns_between_two_samples(library: Library) -> None:
    machine = library("quick_return", "shaper")
    values = {"progress": False, "rtol": 1e-10, "formulation": "reduced"}
    dense = machine.simulate(3.0, np.linspace(0.0, 3.0, 2001), **values)
    sparse = machine.simulate(3.0, [0.0, 3.0], **values)
    assert abs(dense.q("crank.phi")[-1]) > 20.0
    for row in machine.coordinates:
        assert np.abs(np.diff(dense.q(row.name))).max() < 1.0
        assert sparse.q(row.name)[-1] == pytest.approx(dense.q(row.name)[-1], abs=1e-6)


def test_angles_that_turn_are_followed_over_a_hundred_turns(workshop: Path) -> None:
    # A drag-link: ground is the shortest link, so that all bars turn with the crank.
    text = (
        "from codegen import Model\n"
        "model = Model('drag_link')\n"
        "crank = model.body('crank', mass=1.0, inertia=0.5)\n"
        "coupler = model.body('coupler', mass=1.0, inertia=0.5)\n"
        "follower = model.body('follower', mass=1.0, inertia=0.5)\n"
        "model.revolute('O', model.ground.at(0, 0), crank.at(0, 0))\n"
        "model.revolute('C', model.ground.at(0.3, 0), follower.at(0, 0))\n"
        "model.revolute('A', crank.at(1.0, 0), coupler.at(-0.5, 0))\n"
        "model.revolute('B', follower.at(1.0, 0), coupler.at(0.5, 0))\n"
        "model.scene('spin', [], start={crank.phi: 1.0, crank.omega: 30.0},\n"
        "            guess={coupler.phi: 0.2, follower.phi: 2.0, coupler.x: 0.5, coupler.y: 1.0})\n"
    )
    path = workshop / "models" / "drag_link.py"
    write_if_changed(path, text)
    machine = load(path, "spin", folder=workshop)
    # What the integrator errs by in 160 turns goes with the tolerance: 2e-9 rad at this one.
    times = [0.0, 30.0]
    whole = machine.simulate(30.0, times, rtol=1e-13, progress=False)
    less = machine.simulate(30.0, times, rtol=1e-13, formulation="reduced", progress=False)
    assert whole.q("follower.phi")[-1] > 200.0 * np.pi
    assert_same(machine, whole, less, 1e-8)


def test_partitions_are_named_by_what_is_kept(library: Library) -> None:
    machine = library("gear_slider", "train_running")
    less = machine.simulate(0.1, formulation="reduced", progress=False)
    kept = {machine.coordinates.names[k] for k in machine.mechanism.reduced.kept}
    assert less.partitions
    for partition in less.partitions:
        assert set(partition.independent) < kept


# Dead centres


@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-12])
def test_crossing_bars_are_passed(parallelogram: Machine, rtol: float, method: str) -> None:
    whole = parallelogram.simulate(1.0, [0.0, 1.0], rtol=1e-12, progress=False)
    less = parallelogram.simulate(
        1.0, [0.0, 1.0], rtol=rtol, method=method, formulation="reduced", progress=False
    )
    assert len(less.singular) == len(whole.singular) >= 1
    assert less.singular[0].time == pytest.approx(whole.singular[0].time, abs=30.0 * rtol + 1e-9)
    if rtol < 1e-3:
        assert_same(parallelogram, whole, less, max(3e3 * rtol, 1e-8))


ROCKING = """
from math import acos, atan2, cos, sin
from sympy import sign
from codegen import Model

model = Model("rocking")
crank = model.body("crank", mass=1.0, inertia=0.5)
coupler = model.body("coupler", mass=1.0, inertia=0.5)
follower = model.body("follower", mass=1.0, inertia=0.5)
model.revolute("O", model.ground.at(0, 0), crank.at(0, 0))
model.revolute("C", model.ground.at(2.0, 0), follower.at(0, 0))
model.revolute("A", crank.at(1.0, 0), coupler.at(-0.5, 0))
model.revolute("B", follower.at(1.0, 0), coupler.at(0.5, 0))
# A ball that bounces until it lies, and a torque that changes its side with the follower.
ball = model.particle("ball", mass=1.0)
model.gravity("weight", (0, -9.81))
model.contact("floor", gap=ball.y, restitution=0.7)
model.torque("motor", on=follower, value=sign(follower.omega))
model.torque("drag", on=crank, value=-0.1 * crank.omega)
start = {crank.phi: 1.0, crank.omega: 3.0}
guess = {coupler.phi: 0.2, follower.phi: 1.9, coupler.x: 1.0, coupler.y: 1.0}
model.scene("swing", [], without=[ball], start=start, guess=guess)
model.scene("work", ["drag"], without=[ball], start=start, guess=guess, outputs=["energy", "works"])
model.scene("bounced", ["weight", "floor", "motor"], guess=guess,
            start=start | {ball.x: 0.0, ball.vx: 0.0, ball.y: 1.0, ball.vy: 0.0})
# Coupler and follower in one line, 2 m long, as the ground is: the crank's angle is at its largest.
top = acos(0.25)
line = atan2(sin(top), cos(top) - 2.0)
model.scene("stretched", ["weight"], without=[ball], guess={
    crank.phi: top, follower.phi: line, coupler.phi: line + 3.141592653589793,
    coupler.x: 2.0 + 1.5 * cos(line), coupler.y: 1.5 * sin(line)})
"""


def rocking(workshop: Path, scene: str) -> Machine:
    """A four-bar whose crank cannot turn through: its angle turns back."""
    path = workshop / "models" / "rocking.py"
    write_if_changed(path, ROCKING)
    return load(path, scene, folder=workshop)


def independents(result: Result) -> list[tuple[str, ...]]:
    return [partition.independent for partition in result.partitions]


def test_a_coordinate_that_turns_back_is_changed_for_another_and_taken_again(
    workshop: Path,
) -> None:
    machine = rocking(workshop, "swing")
    whole, less = both(machine, 10.0)
    assert np.ptp(np.sign(np.sin(whole.q("follower.phi") - whole.q("coupler.phi")))) == 2.0
    assert_same(machine, whole, less, 1e-8)
    taken = independents(less)
    assert taken[0] == taken[2] == ("crank.phi",)
    assert len(taken) > 15
    assert all(one != other for one, other in pairwise(taken))
    assert less.stats["repartitions"] == len(taken) - 1
    assert less.stats["steps"] < 1.2 * whole.stats["steps"]
    energy = less.energy()
    assert_allclose(energy, energy[0], rtol=1e-8)


@pytest.mark.parametrize("method", ["dopri5", "radau5", "bdf", "auto"])
def test_every_method_passes_dead_centres(workshop: Path, method: str) -> None:
    machine = rocking(workshop, "swing")
    whole = machine.simulate(3.0, [0.0, 3.0], rtol=1e-10, progress=False)
    given = {"rtol": 1e-7, "method": method, "formulation": "reduced", "progress": False}
    less = machine.simulate(3.0, [0.0, 3.0], **given)
    assert_same(machine, whole, less, 1e-3)


def test_samples_at_the_ends_of_steps_are_in_order(workshop: Path) -> None:
    machine = rocking(workshop, "swing")
    less = machine.simulate(3.0, "steps", formulation="reduced", progress=False)
    assert len(less.t) == less.stats["steps"] + 1
    assert np.all(np.diff(less.t) > 0.0)
    assert less.stats["rejected"] < less.stats["steps"]


def test_a_limit_of_steps_counts_those_in_all_coordinates(workshop: Path) -> None:
    machine = rocking(workshop, "swing")
    less = machine.simulate(10.0, formulation="reduced", max_steps=150, progress=False)
    assert less.outcome is Outcome.MAX_STEPS
    assert less.stats["steps"] + less.stats["rejected"] == 150


@pytest.mark.parametrize("scene", ["bounced", "work"])
def test_events_and_works_go_on_through_dead_centres(workshop: Path, scene: str) -> None:
    machine = rocking(workshop, scene)
    whole, less = both(machine, 6.0)
    assert len(independents(less)) > 5
    assert_same(machine, whole, less, 1e-8)
    assert [(e.name, e.direction) for e in less.events] == [
        (e.name, e.direction) for e in whole.events
    ]
    times = [[event.time for event in result.events] for result in (whole, less)]
    assert_allclose(times[1], times[0], rtol=0, atol=1e-8)
    if scene == "bounced":
        assert len(whole.events) > 20
        np.testing.assert_array_equal(less.samples.modes, whole.samples.modes)
    else:
        assert_allclose(less.work("drag"), whole.work("drag"), rtol=1e-8)


def test_a_run_may_start_at_a_dead_centre(workshop: Path) -> None:
    machine = rocking(workshop, "stretched")
    whole, less = both(machine, 1.0)
    assert_same(machine, whole, less, 1e-8)
    taken = independents(less)
    assert taken[0] != ("crank.phi",)
    assert ("crank.phi",) in taken


# Loops that are closed in closed form while a driver moves them, or by contacts

DRIVEN = """
from sympy import sin
from codegen import Model, t

model = Model("tip", gravity=(0, -9.81))
a = model.body("a", mass=1.0, inertia=0.1)
b = model.body("b", mass=1.0, inertia=0.1)
model.revolute("O", model.ground.at(0, 0), a.at(-0.5, 0))
model.revolute("A", a.at(0.5, 0), b.at(-0.5, 0))
model.point_driver("tip", b.at(0.5, 0), "x", 1.2 + 0.1*sin(3*t))
model.scene("run", ["gravity"], drivers=["tip"], start={a.phi: 0.6}, guess={b.phi: -0.6})
"""

CAM = """
from codegen import Model

model = Model("cam", gravity=(0, -9.81))
cam = model.body("cam", mass=1.0, inertia=0.1)
lift = model.body("lift", mass=1.0, inertia=0.1)
model.revolute("O", model.ground.at(0, 0), cam.at(0, 0))
model.translational("G", model.ground.at(0, 0), lift.at(0, 0), axis=(0, 1))
model.cam_flat_follower("C", cam.circle(0.1, (0.02, 0)), lift.at(0, 0))
model.scene("run", ["gravity"], start={cam.phi: 0.3, cam.omega: 5.0}, guess={lift.y: 0.1})
"""


@pytest.mark.parametrize(("name", "text"), [("tip", DRIVEN), ("cam", CAM)])
def test_a_loop_that_moves_with_time_and_a_contact_have_reduced_equations(
    workshop: Path, name: str, text: str
) -> None:
    path = workshop / "models" / f"{name}.py"
    write_if_changed(path, text)
    machine = load(path, "run", folder=workshop)
    assert machine.mechanism.reduced.branches
    whole, less = both(machine, 5.0)
    assert_same(machine, whole, less, 1e-9)
    if name == "cam":  # solved from the row that determines the place of contact
        assert len(independents(less)) == 1


# Refusals


def test_all_that_is_wrong_is_told_at_once(library: Library) -> None:
    machine = library("hard/guide_friction", "running_down")
    with pytest.raises(InputError) as caught:
        machine.simulate(0.1, formulation="reduced", correction="baumgarte", progress=False)
    problems = caught.value.problems
    assert len(problems) == 2
    assert "correction='baumgarte'" in problems[0]
    assert "stick by a force that follows from a reaction" in problems[1]
    assert all('formulation="cartesian"' in problem for problem in problems)


def test_friction_that_sticks_is_refused(library: Library) -> None:
    machine = library("hard/guide_friction", "running_down")
    with pytest.raises(InputError, match="stick by a force that follows from a reaction"):
        machine.simulate(0.1, formulation="reduced", progress=False)


def test_nothing_left_to_integrate_is_refused(library: Library) -> None:
    machine = library("slider_crank", "inverse_dynamics")
    with pytest.raises(InputError, match="nothing is left to integrate"):
        machine.simulate(0.1, formulation="reduced", progress=False)


def test_unknown_formulation_is_refused(compressor: Machine) -> None:
    with pytest.raises(InputError, match="formulation = 'polar' must be one of cartesian, reduced"):
        compressor.simulate(0.1, formulation="polar", progress=False)  # type: ignore[arg-type]


def test_machine_without_its_model(compressor: Machine) -> None:
    alone = Machine(replace(compressor.mechanism, origin=None))
    with pytest.raises(AnalysisError, match="its reduced equations cannot be built"):
        alone.mechanism.reduced  # noqa: B018


# The command line


def test_command_line(workshop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rocking(workshop, "swing")
    monkeypatch.chdir(workshop)
    arguments = ["simulate", "rocking", "--t-end", "0.01", "--scene", "swing", "--points", "3"]
    done = CliRunner().invoke(app, [*arguments, "--formulation", "reduced"])
    assert done.exit_code == 0, done.output
    refused = CliRunner().invoke(app, [*arguments, "--formulation", "polar"])
    assert refused.exit_code == 2


def test_rounding_in_the_reduced_mass_is_no_mass() -> None:
    """That of the place of a contact; it would be the most mobile coordinate by far."""
    none = np.zeros(3, dtype=np.int64)  # is counted by a joint
    mobility = _mobility(np.array([1.0, 4.0, 1e-34]), np.ones(3), none)
    assert_allclose(mobility, [1.0, 0.5, 10.0], rtol=1e-15)
