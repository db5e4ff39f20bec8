"""Particles, and a coupler as a body, as a massless link, and with its mass at the pins."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.reading.scene_selection import valid_scenes
from runtime import Result, load
from tests.codegen.workbench import Interpreted

MASS, LENGTH = 3.0, 1.6


@pytest.fixture(scope="module")
def folder(request: pytest.FixtureRequest) -> Path:
    """A folder whose compiled scenes outlive a run."""
    made: Path = request.config.cache.mkdir("couplers")
    return made


def slider_crank() -> Model:
    """A free-running slider-crank under gravity, its rod a coupler."""
    model = Model("slider_crank", gravity=(0, -9.81))
    inertia = model.parameter("J", 0.2, unit="kg m^2")
    crank = model.body("crank", mass=2.0, inertia=0.4)
    slider = model.body("slider", mass=1.0, inertia=0.1)
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.translational("guide", model.ground, slider, axis=(1, 0))
    rod = model.coupler("rod", crank.at(0.5, 0), slider, LENGTH, mass=MASS, inertia=inertia)
    start = {crank.phi: 0.6, crank.omega: 8.0}
    model.scene("whole", ["gravity"], start=start, guess={rod.x: 1.0, slider.x: 1.9})
    places = {slider.x: 1.9, "rod_half_i.x": 0.4, "rod_half_i.y": 0.3, "rod_half_j.x": 1.9}
    for form in ("link", "lumped"):
        guess = places if form == "lumped" else {slider.x: 1.9}
        model.scene(form, ["gravity"], couplers={rod: form}, start=start, guess=guess)
    return model


def run(folder: Path, scene: str, **inertia: float) -> Result:
    machine = load(slider_crank(), scene, folder=folder)
    instants = np.linspace(0, 1.5, 31)
    found = machine.simulate(1.5, instants, rtol=1e-11, atol=1e-11, parameters=inertia)
    total = found.data["energy"].sel(part="total")
    assert_allclose(total, float(total[0]), rtol=1e-9)
    return found


def test_lumped_rod_moves_as_a_body_with_its_mass_at_the_ends(folder: Path) -> None:
    whole, lumped = run(folder, "whole", J=MASS * LENGTH**2 / 4), run(folder, "lumped")
    for name in ("crank.phi", "slider.x"):
        assert_allclose(lumped.q(name), whole.q(name), atol=1e-9)
    assert_allclose(lumped.reaction("A", "fx"), whole.reaction("A", "fx"), atol=1e-6)
    assert len(lumped.data.coordinate) == 10


def test_massless_link_leaves_the_mass_out(folder: Path) -> None:
    link, whole = run(folder, "link"), run(folder, "whole")
    assert len(link.data.coordinate) == 6
    assert abs(link.q("crank.phi") - whole.q("crank.phi")).max() > 0.1


def test_lumped_mass_costs_little_more_than_the_link() -> None:
    model = slider_crank()
    operations = {}
    for scene in ("whole", "link", "lumped"):
        lowered = Interpreted(model, scene).lowered
        from codegen.lower.operation_count import operations as count

        (kernel,) = (k for k in lowered.program.kernels if k.name == "accelerations")
        operations[scene] = count(lowered.program, kernel)
    assert operations["link"] < operations["lumped"] < 2 * operations["link"]


def test_coupler_may_end_on_the_ground(folder: Path) -> None:
    model = Model("rocker", gravity=(0, -9.81))
    disc = model.body("disc", mass=1.0, inertia=0.2)
    model.coupler("arm", model.ground.at(0, 0), disc, 2.0, mass=1.0, inertia=1.0)
    guess = {disc.y: -2.0, "arm.y": -1.0, "arm.phi": -np.pi / 2}
    model.scene("whole", ["gravity"], start={disc.x: 0.7}, guess=guess)
    guess = {disc.y: -2.0, "arm_half_j.y": -2.0}
    model.scene("lumped", ["gravity"], couplers={"arm": "lumped"}, start={disc.x: 0.7}, guess=guess)
    ends = []
    for scene in ("whole", "lumped"):
        machine = load(model, scene, folder=folder)
        ends.append(machine.simulate(1.0, rtol=1e-11, atol=1e-11).q("disc.x")[-1])
    assert_allclose(*ends, atol=1e-9)


def test_particle_falls_and_hangs(tmp_path: Path) -> None:
    model = Model("conical", gravity=(0, -9.81))
    bob = model.particle("bob", mass=2.0)
    model.distance("string", model.ground.at(0, 0), bob, 1.0)
    model.scene("swing", ["gravity"], start={bob.x: 0.6}, guess={bob.y: -0.8})
    machine = load(model, folder=tmp_path)
    assert machine.coordinates.names == ("bob.x", "bob.y")
    rest = machine.equilibrium()
    assert_allclose([rest["bob.x"], rest["bob.y"]], [0, -1], atol=1e-9)
    found = machine.simulate(2.0, rtol=1e-11, atol=1e-11)
    total = found.data["energy"].sel(part="total")
    assert_allclose(total, float(total[0]), rtol=1e-9)


def test_forces_act_on_particles() -> None:
    model = Model("pair")
    one, other = model.particle("one", 1.0), model.particle("other", 2.0)
    model.spring("tie", one, other, stiffness=3.0, free_length=0.5, damping=0.2)
    model.contact("bump", gap=other.x - one.x - 0.1, stiffness=1e3)
    model.force("push", one, fx=1.0)
    machine = Interpreted(model)
    s = machine.state(3)
    pull = machine.vector("applied_forces", s)
    assert_allclose(pull[:2] + pull[2:], [1.0, 0.0], atol=1e-12)


def test_coupler_without_one_of_its_ends_leaves_nothing_loose() -> None:
    model = Model("cut")
    one, other = model.body("one", 1.0, 1.0), model.body("other", 1.0, 1.0)
    rod = model.coupler("rod", one, other, 1.0, 1.0, 1.0)
    model.scene("s", without=[other], couplers={rod: "lumped"})
    assert valid_scenes(model, "s")[0].bodies == ("one",)
