"""All positions in which joints close, against a solver that shares nothing with ours."""

from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.errors import AnalysisError, AssemblyError, UnknownNameError
from runtime import load
from runtime.assembly.assembly_modes import AssemblyModes
from runtime.machine_facade import Machine

from . import linkages


def angles(modes: AssemblyModes, names: list[str]) -> list[list[float]]:
    return [[mode[f"{name}.phi"] for name in names] for mode in modes]


@pytest.fixture(scope="module")
def butterfly(workshop: Path) -> Machine:
    return load(linkages.double_butterfly(), folder=workshop)


@pytest.fixture(scope="module")
def six_bar(workshop: Path) -> Machine:
    return load(linkages.six_bar(), folder=workshop)


WINGS = ["wing_2", "wing_3", "wing_4", "bar_EH", "bar_GJ", "bar_FK"]
TRIAD = ["crank", "coupler", "rocker", "link"]
EIGHT_SIZES = [dict(linkages.BUTTERFLY, a=1.2 + 0.05 * k, GJ=1.5 - 0.04 * k) for k in range(4)]


def test_double_butterfly_has_all_its_fourteen_modes(butterfly: Machine) -> None:
    modes, true = butterfly.assembly_modes(), linkages.butterfly_modes(0.6)
    assert len(true) == 14
    assert linkages.disagreement(angles(modes, WINGS), true) < 1e-8
    assert len({*modes.labels}) == 14  # its signs name each of them


@pytest.mark.parametrize("k", range(1, 4))
def test_other_double_butterflies_too(butterfly: Machine, k: int) -> None:
    size, angle = EIGHT_SIZES[k], 0.6 - 0.9 * k
    values = linkages.parameters_of(size) | {"angle": angle}
    found = butterfly.assembly_modes(parameters=values)
    assert linkages.disagreement(angles(found, WINGS), linkages.butterfly_modes(angle, size)) < 1e-8


def test_two_modes_a_thousandth_of_a_turn_apart(six_bar: Machine) -> None:
    true = linkages.triad_modes(0.0j, 2.2, -0.1 + 1.6j + 0.5 * np.exp(0.26854j))
    found = np.array(angles(modes := six_bar.assembly_modes(), TRIAD))
    apart = np.abs(np.angle(np.exp(1j * (found[:, None] - found[None])))).max(axis=2)
    nearest = apart[np.triu_indices(6, 1)].min()
    assert 0.0005 < nearest / (2.0 * np.pi) < 0.0015
    assert linkages.disagreement(found.tolist(), true) < 1e-8
    assert len({*modes.labels}) == 6
    assert "det" in modes.signs  # which has opposite signs in the two


def test_seven_bar_with_two_drivers(workshop: Path) -> None:
    machine = load(linkages.seven_bar(), folder=workshop)
    values = {"first_angle": 0.7, "second_angle": 0.0}
    a, k = -0.3 + 0.2j + 0.4 * np.exp(0.7j), 0.4 + 1.6j
    true = linkages.triad_modes(a, 2.2, k)
    assert len(true) == 6
    assert (
        linkages.disagreement(angles(machine.assembly_modes(parameters=values), TRIAD), true) < 1e-8
    )


def test_slider_crank_in_closed_form(library) -> None:
    machine = library("slider_crank", "kinematics")
    angle, rod = machine.assemble()["crank.phi"], machine.parameters["rod_length"].default
    found = sorted(mode["slider.x"] for mode in machine.assembly_modes())
    reach = np.sqrt(rod**2 - (2.0 * np.sin(angle)) ** 2)
    np.testing.assert_allclose(found, 2.0 * np.cos(angle) + reach * np.array([-1, 1]), atol=1e-12)


def test_undriven_machine_with_a_coordinate_held(library) -> None:
    machine = library("four_bar", "constant_torque")
    modes = machine.assembly_modes(start={"crank.phi": 1.0, "crank.omega": 2.0})
    assert modes.labels == ("+", "-")
    assert modes.signs == ("B-C-D",)
    c = np.array([mode["coupler.x"] + 1j * mode["coupler.y"] for mode in modes])  # the pin C
    b = np.exp(1j)  # and the pin B
    assert (np.sign((np.conj(c - b) * (2.0 - c)).imag) == [1.0, -1.0]).all()
    for mode in modes:
        assert mode["crank.phi"] == 1.0
        assert mode["crank.omega"] == 2.0
        assert max(mode.residual.values()) < 1e-13
        run = machine.simulate(0.01, 2, start=mode, progress=False)
        assert run.q("rocker.phi")[0] == mode["rocker.phi"]
        assert machine.assemble({"rocker.phi": mode["rocker.phi"]})


def test_a_driven_motion_stays_in_the_mode_in_which_it_starts(library) -> None:
    machine = library("four_bar", "inverse_dynamics")
    later = machine.assembly_modes(t=0.4)
    for mode in machine.assembly_modes(t=0.1):
        run = machine.kinematics([0.1, 0.4], start=mode)
        np.testing.assert_allclose(run.q("rocker.phi")[0], mode["rocker.phi"], atol=1e-12)
        apart = [abs(np.exp(1j * run.q("coupler.phi")[1]) - np.exp(1j * one["coupler.phi"]))
                 for one in later]  # fmt: skip
        assert min(apart) < 1e-10
        assert np.isfinite(machine.inverse_dynamics([0.1], start=mode).reaction("A", "fx")).all()


def test_redundant_cranks_of_a_parallelogram(workshop: Path) -> None:
    model = Model("three_cranks")
    bar = model.body("bar", mass=1.0, inertia=1.0)
    for k in range(3):
        crank = model.body(f"crank_{k}", mass=1.0, inertia=1.0)
        model.revolute(f"A{k}", model.ground.at(k, 0), crank.at(0, 0))
        model.revolute(f"B{k}", crank.at(0.5, 0), bar.at(k, 0))
    model.driver("drive", model.bodies["crank_0"].phi, 0.7)
    model.scene("driven", drivers=["drive"], analysis="kinematics")
    (mode,) = load(model, folder=workshop).assembly_modes()  # the mirrored ones need two cranks
    np.testing.assert_allclose([mode[f"crank_{k}.phi"] for k in range(3)], 0.7, atol=1e-12)
    assert mode.redundant


def test_modes_that_meet_are_one_and_it_says_so(library) -> None:
    machine = library("four_bar", "constant_torque")
    modes = machine.assembly_modes(parameters={"BC": 2.0, "CD": 1.0}, start={"crank.phi": 0.0})
    assert len(modes) == 1
    assert "modes meet" in repr(modes)


def test_freedom_that_is_left_is_refused_by_name(library) -> None:
    machine = library("four_bar", "constant_torque")
    square = {"AB": 1.0, "BC": 1.0, "CD": 1.0, "AD": 1.0}
    with pytest.raises(AnalysisError, match=r"1 degree of freedom left: .* coupler\.phi, rock"):
        machine.assembly_modes(parameters=square, start={"crank.phi": 0.0})
    with pytest.raises(AnalysisError, match=r'Hold it with start=\{"crank\.phi": \.\.\.\}'):
        library("slider_crank", "gravity_equilibrium").assembly_modes()


def test_gears_are_refused_and_belts_are_not(workshop: Path) -> None:
    """The equation of gears closes at angles at which no teeth mesh."""
    for kind in ("gear", "belt"):
        model = Model(f"{kind}s")
        one, other = (model.body(name, mass=1.0, inertia=1.0) for name in ("one", "other"))
        model.revolute("A", model.ground.at(0, 0), one.at(0, 0))
        model.revolute("D", model.ground.at(3, 0), other.at(0, 0))
        getattr(model, kind)("mesh", one, other, 1, 2)
        model.driver("drive", one.phi, 0.7)
        model.scene("driven", drivers=["drive"], analysis="kinematics")
        machine = load(model, folder=workshop)
        if kind == "belt":
            assert [mode["other.phi"] for mode in machine.assembly_modes()] == [pytest.approx(0.35)]
        else:
            with pytest.raises(AnalysisError, match="gears close mesh also at angles"):
                machine.assembly_modes()


def test_joints_that_cannot_close(library) -> None:
    machine = library("four_bar", "kinematics")
    with pytest.raises(AssemblyError, match="joint"):
        machine.assembly_modes(parameters={"AD": 9.0})


def test_a_mode_is_found_by_number_and_signs(library) -> None:
    modes = library("four_bar", "kinematics").assembly_modes(0.1)
    assert modes["-"] is modes[1]
    assert len(modes) == 2
    with pytest.raises(UnknownNameError, match="There is no single mode '\\+\\+'"):
        modes["++"]
    assert "A-B-C" in repr(modes)
