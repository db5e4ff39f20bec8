"""Assembly: closed joints, held start values, and errors that name the culprit."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy

from codegen import Model
from codegen.errors import AssemblyError, RedundancyError
from runtime import load
from runtime.assembly.open_joints import misses
from runtime.assembly.redundancy import Dependency, dependent_rows
from runtime.machine_facade import Machine
from runtime.mechanism.table_rows import StartValue, Table


def starting(machine: Machine, *start: tuple[str, float, str]) -> Machine:
    """The machine with another start in its scene; the kernels know of none."""
    description = replace(machine.description, start=Table(StartValue(*row) for row in start))
    return Machine(replace(machine.mechanism, description=description, origin=None))


def _slider(phi: float, rod: float = 3.5) -> float:
    return float(2.0 * np.cos(phi) + np.sqrt(rod**2 - 4.0 * np.sin(phi) ** 2))


def test_driven_position_of_the_book(driven: Machine) -> None:
    start = driven.assemble()
    with pytest.raises(AttributeError, match=r"Assembly has no .x.; it has .*degrees_of_freedom"):
        _ = start.x  # type: ignore[attr-defined]
    assert start["crank.phi"] == pytest.approx(np.pi / 4, abs=1e-15)
    assert start["slider.x"] == pytest.approx(_slider(np.pi / 4), abs=1e-14)
    assert start["rod.phi"] == pytest.approx(-0.41595, abs=5e-6)
    assert start["crank.omega"] == pytest.approx(2 * np.pi, abs=1e-13)
    assert set(start.residual) == {"A", "B", "C", "guide", "crank_drive"}
    assert max(start.residual.values()) < 1e-14
    assert max(start.velocity_residual.values()) < 1e-13


def test_report_says_what_moved(driven: Machine) -> None:
    start = driven.assemble()
    moved = {row.name: row for row in start.moved}
    assert moved["slider.x"].asked == 4.6
    assert moved["slider.x"].by == pytest.approx(_slider(np.pi / 4) - 4.6)
    assert "crank.x" not in moved
    text = str(start)
    assert "degrees of freedom: 0" in text
    assert "slider.x moved from 4.6 to 4.61578 m" in text


@pytest.mark.parametrize(("guess", "sign"), [({"slider.x": 4.0}, 1), ({"slider.x": -1.5}, -1)])
def test_guess_chooses_the_branch(driven: Machine, guess: dict[str, float], sign: int) -> None:
    guess |= {"rod.phi": 0.0 if sign > 0 else np.pi, "rod.x": guess["slider.x"] / 2}
    x = driven.assemble(guess)["slider.x"]
    root = np.sqrt(3.5**2 - 2.0)
    assert x == pytest.approx(np.sqrt(2.0) + sign * root, abs=1e-13)


def test_assembly_from_nothing_but_a_crank_angle(free: Machine) -> None:
    start = starting(free, ("crank.phi", 2.0, "fixed")).assemble()
    assert start["crank.phi"] == 2.0
    assert abs(start["slider.x"] - 2.0 * np.cos(2.0)) == pytest.approx(
        np.sqrt(3.5**2 - 4.0 * np.sin(2.0) ** 2), abs=1e-13
    )


def test_fixed_velocity_is_held_and_the_others_follow(free: Machine) -> None:
    """The book's start of the compressor."""
    machine = starting(
        free,
        ("crank.phi", np.pi, "fixed"),
        ("rod.x", -0.25, "guess"),
        ("slider.x", 1.5, "guess"),
        ("crank.omega", 30.0, "fixed"),
    )
    start = machine.assemble()
    assert start["crank.omega"] == 30.0
    assert start["rod.vy"] == pytest.approx(-30.0, abs=1e-12)
    assert start["rod.omega"] == pytest.approx(120.0 / 7.0, abs=1e-12)
    assert start["slider.vx"] == pytest.approx(0.0, abs=1e-12)
    assert start.degrees_of_freedom == 1


CRANKS: dict[str, tuple[bool, list[tuple[str, float, str]], dict[str, Any], list[str]]] = {
    "fixed positions": (
        False, [("crank.phi", 0.0, "fixed"), ("slider.x", 5.0, "fixed"), ("rod.x", 3.0, "guess")],
        {}, ["leave joints open at t = 0 s from these guesses, and nearer guesses may close them",
             "Start says crank.phi = 0 rad, slider.x = 5 m", "joint C misses by",
             "Make one of them a guess (guess=), or correct its value."],
    ),
    "fixed velocities": (
        False, [("crank.phi", 1.0, "fixed"), ("slider.x", 4.1, "guess"), ("rod.x", 2.6, "guess"),
                ("crank.omega", 1.0, "fixed"), ("slider.vx", 5.0, "fixed")],
        {}, ["fixed start velocities contradict the joints",
             "crank.omega = 1 rad/s, slider.vx = 5 m/s", "misses by"],
    ),
    "a driver": (
        True, [("crank.phi", 0.5, "fixed")], {}, ["driver crank_drive misses by 0.2854 rad"],
    ),
    "out of reach": (
        True, [], {"parameters": {"l": 1.0}}, ["asks for 0.262 rad more than",
             "the joints close, but not with what the drivers (crank_drive) demand"],
    ),
    "a parameter out of scale": (
        True, [], {"parameters": {"l": 1e200}}, ["out of scale", "Given: l = 1e+200"],
    ),
    "a guess out of scale": (
        True, [], {"guess": {"slider.x": 1e300}}, ["out of scale", "slider.x = 1e+300"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", CRANKS)
def test_what_contradicts_the_joints_is_named(driven: Machine, free: Machine, what: str) -> None:
    is_driven, start, given, said = CRANKS[what]
    machine = driven if is_driven else free
    machine = starting(machine, *start) if start else machine
    with pytest.raises(AssemblyError) as caught:
        machine.assemble(**given)
    assert not isinstance(caught.value, RedundancyError)
    assert all(text in str(caught.value) for text in said)


def test_start_sets_what_the_scene_fixes(free: Machine) -> None:
    machine = starting(free, *CRANKS["fixed positions"][1])
    assert machine.assemble(start={"slider.x": 5.5})["slider.x"] == 5.5


@pytest.mark.parametrize(
    ("kind", "scene", "options", "given", "text"),
    [
        ("slider_crank", "twice", {"twice": True}, {"tilt": 0.1},
         r"second_guide\.phi is redundant and contradictory"),
        ("overdriven", "twin", {}, {}, "driver second_drive fights the joints.*crank_drive"),
    ],
)  # fmt: skip
def test_constraints_that_contradict_each_other_are_named(
    make: Callable[..., Machine], kind: str, scene: str, options: dict[str, bool],
    given: dict[str, float], text: str,
) -> None:  # fmt: skip
    with pytest.raises(RedundancyError, match=text):
        make(kind, scene, **options).assemble(parameters=given)


def test_joints_that_are_undefined_elsewhere_are_named(tmp_path: Path) -> None:
    """A track y = √x has no slope at the negative x that a search for redundancy may try."""
    model = Model("root")
    b = model.body("b", mass=1.0, inertia=1.0)
    model.constraint("track", sympy.sqrt(b.x) - b.y)
    machine = load(model, model.scene("fall", start={"b.x": 0.05, "b.y": 5.0, "b.phi": 0.0}),
                   folder=tmp_path)  # fmt: skip
    with pytest.raises(AssemblyError, match=r"contradict the joints .* track misses by 4\.776 m"):
        machine.assemble()


def test_rows_that_are_not_finite_depend_on_nothing() -> None:
    matrix = np.array([[1.0, 0.0], [np.nan, 1.0], [2.0, 0.0], [np.inf, 0.0]])
    assert dependent_rows(matrix, [0, 1, 2, 3]) == [Dependency(2, (0,))]


def test_joints_that_cannot_close(make: Callable[..., Machine]) -> None:
    """A slider held at 10 m is out of reach of a crank of 2 m and a rod of 3.5 m."""
    machine = make("far_slider", "far")
    with pytest.raises(AssemblyError) as caught:
        machine.assemble()
    text = str(caught.value)
    assert "cannot be assembled at t = 0 s" in text
    gaps = [float(part.split(" m")[0]) for part in text.split("misses by ")[1:]]
    assert sum(gaps) == pytest.approx(4.5, abs=1e-3)
    assert "joint stop misses by" in text


def test_redundant_constraint_is_named(make: Callable[..., Machine]) -> None:
    start = make("slider_crank", "twice", twice=True).assemble()
    text = str(start)
    assert "second_guide.phi is redundant and consistent: it follows from guide" in text
    assert start.redundant == (("second_guide.phi", "second_guide", ("guide",)),)
    assert set(start.not_unique) == {"guide", "second_guide"}
    assert len(start.independent) == 8
    assert start.degrees_of_freedom == 1


def test_redundancy_that_follows_from_the_dimensions(make: Callable[..., Machine]) -> None:
    """A parallelogram with three cranks moves; with one crank of 9 m it does not close."""
    machine = make("parallelogram", "three")
    start = machine.assemble()
    assert str(start).count("is redundant and consistent") == 1
    (found,) = start.redundant
    assert found.element == "third_top"
    assert (len(start.independent), start.degrees_of_freedom) == (14, 1)
    with pytest.raises(AssemblyError, match="cannot be assembled"):
        machine.assemble(parameters={"third": 9.0})


def test_body_without_joints(make: Callable[..., Machine]) -> None:
    machine = make("loose", "loose")
    start = machine.assemble({"stone.vx": 3.0, "stone.y": 2.0})
    assert start.degrees_of_freedom == 3
    assert start.residual == {}
    result = machine.simulate(1.0, [0.0, 1.0], guess={"stone.vx": 3.0})
    assert result.q("stone.x")[1] == pytest.approx(3.0, abs=1e-12)
    assert result.q("stone.y")[1] == pytest.approx(-0.5 * 9.81, abs=1e-12)
    assert machine.equilibrium().failed


def test_dead_centre_is_no_redundancy(driven: Machine) -> None:
    """Rod and crank of equal length, the crank upright: singular here, not everywhere."""
    start = driven.assemble(
        {"slider.x": 0.1, "rod.x": 0.1, "rod.phi": -1.5},
        parameters={"l": 2.0, "phi0": np.pi / 2, "omega0": 0.0},
    )
    assert start.singular
    assert "Singular position" in str(start)
    assert start.degrees_of_freedom == 0


def test_unknown_and_infinite_start_values(free: Machine) -> None:
    with pytest.raises(AssemblyError) as caught:
        free.assemble({"crank.ph": 1.0, "rod.x": np.inf, "rod.y": "up"})  # type: ignore[dict-item]
    assert len(caught.value.problems) == 3
    assert "no coordinate or velocity 'crank.ph'; nearest: crank.phi" in caught.value.problems[0]
    assert "rod.x is inf" in caught.value.problems[1]
    assert "rod.y is 'up'; it must be a finite number" in caught.value.problems[2]
    with pytest.raises(KeyError, match=r"nearest: crank\.phi"):
        free.assemble()["crank.ph"]


def test_assembly_is_the_nearest_position(free: Machine) -> None:
    """Along the motion the objective (q - q0)^T W (q - q0) does not fall."""
    start = free.assemble()
    asked = np.array([0, 0, 0.8, 3.0, 0, -0.4, 4.6, 0, 0])
    weight = np.where(np.isin(np.arange(9), [2, 3, 5, 6]), 1.0, 1e-3)
    size = 2.0

    def distance(phi: float) -> float:
        rod = -np.arcsin(2.0 * np.sin(phi) / 3.5)
        x = _slider(phi)
        q = np.array([0, 0, phi, x - 1.75 * np.cos(rod), -1.75 * np.sin(rod), rod, x, 0, 0])
        scale = np.array([size, size, 1.0] * 3)
        return float(weight @ ((q - asked) / scale) ** 2)

    phi = start["crank.phi"]
    assert distance(phi) < distance(phi + 0.01)
    assert distance(phi) < distance(phi - 0.01)


def test_gaps_that_are_rounding_beside_the_worst_are_not_named() -> None:
    rows = [SimpleNamespace(element=element) for element in ("spin", "R", "S")]
    task: Any = SimpleNamespace(t=0.0, equations=SimpleNamespace(
        description=SimpleNamespace(drivers={"spin"}, constraints=rows),
        slopes=lambda t, q: None, row_units=lambda slopes: ["rad", "m", "m"],
    ))  # fmt: skip
    said = misses(task, np.zeros(1), np.array([0.8, 9e-10, 1e-3]), 1e-10)
    assert said == "driver spin misses by 0.8 rad, joint S misses by 0.001 m"


def test_the_gap_of_a_link_is_a_difference_of_squares(tmp_path: Path) -> None:
    """At the angle 0 the ends are 4 m apart, and the link is 2 m long."""
    model = Model("link")
    arm = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("O", model.ground.at(0, 0), arm.at(0, 0))
    model.distance("wire", model.ground.at(5, 0), arm.at(1, 0), 2.0)
    scene = model.scene("still", start={arm.x: 0.0, arm.y: 0.0, arm.phi: 0.0})
    with pytest.raises(AssemblyError, match=r"joint wire misses by 12 m\^2\."):
        load(model, scene, folder=tmp_path).assemble()


@pytest.mark.parametrize(("phi", "velocity"), [(0.0, "vx"), (np.pi / 2, "vy")])
def test_a_velocity_along_a_bar_is_refused(phi: float, velocity: str, workshop: Path) -> None:
    """The rate would be divided by a sine or cosine that is zero but for rounding."""
    model = Model("bar")
    bar = model.body("b", 1.0, 0.1)
    model.revolute("R", model.ground.at(0, 0), bar.at(-0.7, 0))
    model.scene("s", guess={"b.x": 0.6, "b.y": 0.3})
    machine = load(model, folder=workshop)
    with pytest.raises(AssemblyError, match=r"contradict the joints.* R misses by 1 m/s"):
        machine.assemble(start={"b.phi": phi, f"b.{velocity}": 1.0})
    near = machine.assemble(start={"b.phi": phi + 1e-6, f"b.{velocity}": 1e-6})
    assert abs(near["b.omega"]) == pytest.approx(1.0 / 0.7, rel=1e-6)
