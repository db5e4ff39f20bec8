"""Equations in reduced coordinates against those of the same machine in all of them."""

import math
from itertools import product
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.driver import translate
from codegen.generated_files.generated_file import Clock
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import Lowered
from codegen.lower.program import Op
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes
from codegen.reduce.reduced_kernels import Reduced, reduce
from tests.random_mechanisms import Scales, random_mechanism

MACHINES = [
    ("slider_crank", "compressor"),
    ("slider_crank", "compressor_massless_rod"),
    ("slider_crank", "inverse_dynamics"),
    ("four_bar", "constant_torque"),
    ("film_follower", "motor"),
    ("web_cutter", "running"),
    ("quick_return", "shaper"),
    ("rack_and_pinion", "running"),
    ("rack_and_pinion", "running_massless_coupler"),
    ("gear_slider", "train_running"),
    ("gear_slider", "train_inverse_dynamics"),
    ("gear_slider", "planetary_inverse_dynamics"),
    ("valve_lifter", "free_follower"),
    ("coil_spring", "impact"),
    ("hard/andrews", "released"),
    ("hard/n_four_bar", "fall"),
    ("hard/double_pendulum", "thrown"),
    ("hard/equal_rods", "spin"),
    ("hard/mass_ratio", "turning"),
    ("hard/guide_friction", "creeping"),
    ("hard/spring_chain", "struck"),
    ("hard/pendulum", "point"),
    ("hard/contact_follower", "thrown"),
]
KEPT = {
    "slider_crank compressor": (["crank.phi"], [], ["rod.phi"]),
    "quick_return shaper": (["crank.phi"], [], ["rocker.phi", "rod.phi"]),
    "hard/andrews released": (["K1.phi"], [], ["K2.phi", "K4.phi", "K6.phi"]),
    "hard/double_pendulum thrown": (["upper.phi", "lower.phi"], [], []),
    "gear_slider train_running": (["pinion.phi", "wheel.phi"], ["mesh"], ["rod.phi"]),
    "hard/pendulum point": (["bob.x", "bob.y"], ["rod"], []),
}


def lowered(root: Path, name: str, scene: str) -> Lowered:
    return lowered_model(read_model(root / "models" / f"{name}.py").model, scene)


def lowered_model(model: Model, scene: str) -> Lowered:
    (chosen,) = valid_scenes(model, scene)
    return translate(model, chosen, Clock({}, lambda message: None, ""))[1]


class Both:
    """A machine in both formulations, interpreted."""

    def __init__(self, scene: Lowered) -> None:
        self.scene, self.told = scene, scene.description
        self.reduced: Reduced = reduce(scene)
        self.p = [value for _, value, *_ in self.told.parameters]
        self.modes = [k % 2 for k in range(len(self.told.switches))]

    def ask(self, kernel: str, array: str, **arguments: Any) -> np.ndarray:
        return self._ask(self.scene.program, kernel, array, p=self.p, **arguments)

    def ask_reduced(self, kernel: str, array: str, **arguments: Any) -> np.ndarray:
        return self._ask(self.reduced.program, kernel, array, **arguments)

    def _ask(self, program: Any, kernel: str, array: str, **arguments: Any) -> np.ndarray:
        out = evaluate(program, kernel, {"modes": self.modes, **arguments}, math).get(array, {})
        return np.array([out[slot] for slot in sorted(out)])

    def states(self, count: int) -> list[dict[str, Any]]:
        """Random states of the coordinates that are kept, on what is left of the constraints."""
        found: list[dict[str, Any]] = []
        n, m = len(self.reduced.kept), len(self.reduced.closures)
        start = {name: value for name, value, _ in self.told.start}
        names = [self.told.coordinates[k][0] for k in self.reduced.kept]
        largest = np.zeros(len(self.reduced.branches))
        sides = list(product((1.0, -1.0), repeat=len(self.reduced.branches)))
        for attempt in range(400):
            random = Random(attempt)
            q = np.array([start.get(name, 0.3) + random.uniform(-0.3, 0.3) for name in names])
            v = np.array([random.uniform(-2.0, 2.0) for _ in range(n)])
            p = [*self.p, *random.choice(sides)]
            given: dict[str, Any] = {"t": random.uniform(0.0, 0.2), "p": p, "w": [1.0] * n}
            try:
                for _ in range(20 if m else 0):
                    q = q + self.ask_reduced("correction", "dq", q=q, v=v, **given)
                if m:
                    v = v + self.ask_reduced("correction", "dv", q=q, v=v, **given)
                    missing = self.ask_reduced("constraints", "phi", q=q, **given)
                    if not np.abs(missing).max() < 1e-15:
                        continue
                near = self.ask_reduced("dead_centres", "out", q=q, v=v, **given)[::3]
            except (ValueError, OverflowError, ZeroDivisionError):
                continue
            largest = np.maximum(largest, near)
            if np.all(near > 0.05 * largest):
                found.append({"q": q, "v": v, "t": given["t"], "p": p})
            if len(found) == count:
                return found
        raise AssertionError(f"only {len(found)} states found")

    def all_of(self, state: dict[str, Any]) -> dict[str, Any]:
        """The same state in all coordinates."""
        turns = [0.0] * len(self.reduced.angles)
        q = self.ask_reduced("expand", "all_q", turns=turns, **state)
        v = self.ask_reduced("expand", "all_v", turns=turns, **state)
        return {"t": state["t"], "q": q, "v": v}


@pytest.fixture(scope="module", params=MACHINES, ids=" ".join)
def both(root: Path, request: pytest.FixtureRequest) -> Both:
    return Both(lowered(root, *request.param))


def test_states_lie_on_all_constraints(both: Both) -> None:
    for state in both.states(4):
        whole = both.all_of(state)
        phi = both.ask("constraints", "phi", **whole)
        size = max(1.0, np.abs(whole["q"]).max())
        assert_allclose(phi, 0.0, atol=4e-15 * size)
        entries = both.ask("jacobian", "values", **whole)
        rates = -both.ask("velocity_rhs", "nu", **whole)
        for row, column, entry in zip(
            both.told.jacobian.rows, both.told.jacobian.columns, entries, strict=True
        ):
            rates[row] += entry * whole["v"][column]
        assert_allclose(rates, 0.0, atol=2e-13 * max(1.0, np.abs(whole["v"]).max()))
        kept = list(both.reduced.kept)
        assert_allclose(whole["q"][kept], state["q"], rtol=0, atol=0)
        assert_allclose(whole["v"][kept], state["v"], rtol=0, atol=0)


def test_accelerations_and_multipliers_are_the_machines_own(both: Both) -> None:
    for state in both.states(4):
        whole = both.all_of(state)
        theirs = both.ask("accelerations", "a", **whole)
        ours = both.ask_reduced("accelerations", "a", **state)
        kept = list(both.reduced.kept)
        assert_allclose(ours, theirs[kept], rtol=1e-9, atol=1e-11 * np.abs(theirs).max())


def test_events_are_asked_for_by_the_same_functions(both: Both) -> None:
    if not both.told.switches:
        pytest.skip("nothing switches")
    for state in both.states(4):
        whole = both.all_of(state)
        a = both.ask("accelerations", "a", **whole)
        own = [a[k] for k in both.reduced.kept]
        for kernel, array, more, less in (
            ("switching", "g", {}, {}),
            ("switching_rates", "rate", {"a": a}, {"a": own}),
        ):
            theirs = both.ask(kernel, array, **whole, **more)
            ours = both.ask_reduced(kernel, array, **state, **less)
            assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(a).max()))


def test_sign_of_a_loop_is_its_branch(both: Both) -> None:
    if not both.reduced.branches:
        pytest.skip("no loop is closed in closed form")
    count = len(both.reduced.branches)
    for state in both.states(4):
        whole = both.all_of(state)
        p = [*both.p, *[1.0] * count]
        sides = both.ask_reduced("branches", "out", t=whole["t"], q=whole["q"], p=p)
        assert_allclose(np.sign(sides), state["p"][-count:])
        room, _, most = both.ask_reduced("dead_centres", "out", **state).reshape(-1, 3).T
        assert_allclose(sides**2, room, rtol=1e-8)
        assert np.all(room <= most * (1.0 + 1e-12))


def test_rates_of_dead_centres_are_derivatives(both: Both) -> None:
    if not both.reduced.branches:
        pytest.skip("no loop is closed in closed form")
    for state in both.states(2):
        step = 1e-5
        ends = [
            both.ask_reduced(
                "dead_centres",
                "out",
                **{**state, "t": state["t"] + d, "q": state["q"] + d * state["v"]},
            )
            for d in (-step, step)
        ]
        slopes = (ends[1] - ends[0])[::3] / (2.0 * step)
        now = both.ask_reduced("dead_centres", "out", **state)
        assert_allclose(now[1::3], slopes, rtol=1e-5, atol=1e-6 * max(1.0, np.abs(now).max()))


@pytest.mark.parametrize("which", KEPT)
def test_what_is_kept(root: Path, which: str) -> None:
    scene = lowered(root, *which.split())
    names = [name for name, *_ in scene.description.coordinates]
    reduced = reduce(scene)
    kept, closures, branches = KEPT[which]
    assert [names[k] for k in reduced.kept] == kept
    assert [scene.description.constraints[i][0] for i in reduced.closures] == closures
    assert [names[k] for k, _ in reduced.branches] == branches


def test_a_link_between_two_bodies_of_one_pin_closes_no_loop() -> None:
    """The angle of the body before them cancels, but for rounding."""
    scene = lowered_model(random_mechanism(0, scales=Scales()).model(), "run")
    reduced = reduce(scene)
    assert reduced.branches == ()
    assert "link0" in [scene.description.constraints[i][0] for i in reduced.closures]


def test_the_place_of_a_contact_keeps_its_row_and_has_no_mass() -> None:
    """A lever is solved from the other row; with the place it moves only where nothing touches."""
    machine = random_mechanism(15, scales=Scales())
    both = Both(lowered_model(machine.model(), "run"))
    rows = both.scene.description.constraints
    assert [rows[i][::2] for _, i in both.reduced.branches] == [("lift0", "across")]
    order = [
        machine.parts.coordinates.index(name) for name, *_ in both.scene.description.coordinates
    ]
    q, v = machine.q[order], machine.v[order]
    kept, p = list(both.reduced.kept), [*both.p, 1.0]
    side = both.ask_reduced("branches", "out", t=0.0, q=q, p=p)
    p[-1] = math.copysign(1.0, side[0])
    theirs = both.ask("accelerations", "a", t=0.0, q=q, v=v)[kept]
    ours = both.ask_reduced("accelerations", "a", t=0.0, q=q[kept], v=v[kept], p=p)
    assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
    mass = both.ask_reduced("reduced_mass", "values", t=0.0, q=q[kept], p=p)
    place = [*both.reduced.mass.rows].index(2)
    assert abs(mass[place]) < 1e-24 * np.abs(mass).max()


def test_whole_turns_move_what_turns_with_the_angle(root: Path) -> None:
    both = Both(lowered(root, "quick_return", "shaper"))
    (state, *_) = both.states(1)
    plain = both.ask_reduced("expand", "all_q", turns=[0.0] * len(both.reduced.angles), **state)
    for slot, column in enumerate(both.reduced.angles):
        turns = [0.0] * len(both.reduced.angles)
        turns[slot] = 3.0
        moved = both.ask_reduced("expand", "all_q", turns=turns, **state) - plain
        assert_allclose(moved[column], 6.0 * math.pi, rtol=1e-12)
        places = [k for k, (*_, unit) in enumerate(both.told.coordinates) if unit == "m"]
        assert_allclose(moved[places], 0.0, atol=1e-15)


def test_root_of_a_loop_and_quotient_are_taken_at_once(root: Path) -> None:
    """1/(c √S) as √S/S/c: the division by S does not wait for the root."""
    program = reduce(lowered(root, "slider_crank", "compressor")).program
    (kernel,) = (k for k in program.kernels if k.name == "accelerations")
    found = [program.values[number] for number in program.reachable(kernel)]
    divisors = {value.args[1] for value in found if value.op is Op.DIV}
    under_roots = {value.args[0] for value in found if value.op is Op.SQRT}
    assert under_roots
    assert under_roots <= divisors
