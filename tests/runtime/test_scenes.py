"""Scenes at run time: what they leave out changes nothing else, and asking for it says so."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Expr, Piecewise, cos

from codegen import Model, t
from codegen.errors import AnalysisError, InputError, ModelError, ParameterError
from runtime import Machine, Result, load

INSTANTS = np.linspace(0.0, 1.0, 21)


def swing() -> Model:
    """A pendulum with a damper, a torque and a spring, all with coefficients that may vanish."""
    model = Model("swing", gravity=(0, -9.81))
    c = model.parameter("c", 0.3, unit="N m s/rad")
    push = model.parameter("push", 1.5, unit="N m")
    k = model.parameter("k", 20.0, unit="N/m")
    mu = model.parameter("mu", 0.2)
    bob = model.body("bob", mass=2.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("damper", on=bob, value=-c * bob.omega)
    model.torque("motor", on=bob, value=push, when=bob.omega > 0)
    model.spring("spring", model.ground.at(0, 2), bob, k, free_length=0.5)
    model.friction("rub", hinge, mu, creep=1e-1, radius=0.1, fidelity="regularised")
    model.scene("all", ["gravity", "damper", "motor", "spring", "rub"],
                start={bob.phi: -1.0, bob.omega: 0.5})  # fmt: skip
    return model


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scenes")


@pytest.fixture(scope="module")
def whole(folder: Path) -> Machine:
    return load(swing(), "all", folder=folder)


def run(machine: Machine, **parameters: float) -> Result:
    return machine.simulate(1.0, INSTANTS, rtol=3e-14, atol=1e-14, parameters=parameters)


@pytest.mark.parametrize(
    ("effect", "coefficient"), [("damper", "c"), ("motor", "push"), ("spring", "k"), ("rub", "mu")]
)
def test_leaving_out_is_a_coefficient_of_zero(
    effect: str, coefficient: str, whole: Machine, folder: Path
) -> None:
    model = swing()
    bare = load(model, model.scene("all").without(effect), folder=folder)
    assert bare.scene == f"all_without_{effect}"
    assert coefficient not in bare.parameters.names
    with_none, without = run(whole, **{coefficient: 0.0}), run(bare)
    assert_allclose(without.samples.q, with_none.samples.q, rtol=0, atol=1e-12)
    assert_allclose(without.samples.v, with_none.samples.v, rtol=0, atol=1e-12)
    assert np.abs(without.q("bob.phi") - run(whole).q("bob.phi")).max() > 1e-4
    if effect == "motor":
        assert not bare.description.switches
        assert not without.events


def test_outputs_change_no_digit_of_the_motion(whole: Machine, folder: Path) -> None:
    model = swing()
    told = run(whole)
    for outputs in ([], ["energy", "reaction(hinge)", "power(motor)"]):
        machine = load(model, model.scene("all").with_(outputs=outputs), folder=folder)
        found = run(machine)
        assert (found.samples.q == told.samples.q).all()
        assert (found.samples.a == told.samples.a).all()
        assert found.data.attrs["scene"] == machine.scene
        if "energy" in outputs:
            assert (found.energy() == told.energy()).all()
            assert (found.power("motor") == told.power("motor")).all()
            assert (found.reaction("hinge", "fx") == told.reaction("hinge", "fx")).all()
        else:
            assert np.isnan(found.samples.lam).all()


def test_what_was_not_asked_for_is_offered(folder: Path) -> None:
    model = swing()
    machine = load(model, model.scene("all").with_(outputs=["power(motor)"]), folder=folder)
    found = run(machine)
    with pytest.raises(InputError) as caught:
        found.work("damper")
    assert "does not compute work(damper)" in str(caught.value)
    assert "outputs=['power(motor)', 'work(damper)']" in str(caught.value)
    with pytest.raises(AnalysisError, match=r"needs the potential energy.*outputs="):
        machine.equilibrium()
    assert "energy" not in found.data


def test_parameter_of_what_is_left_out_is_refused(folder: Path) -> None:
    model = swing()
    machine = load(model, model.scene("all").without("spring"), folder=folder)
    with pytest.raises(
        ParameterError, match=r"nothing that takes part depends on parameter k.*spri"
    ):
        machine.parameter_values({"k": 1.0})


def test_scene_for_equilibrium_rests_where_the_whole_does(folder: Path) -> None:
    model = swing()
    calm = model.scene("all").without("motor", "rub")
    whole = load(model, calm, folder=folder).equilibrium()
    only = load(model, calm.with_(analysis="equilibrium"), folder=folder)
    rest = only.equilibrium()
    assert rest["bob.phi"] == whole["bob.phi"]
    assert rest.stability == whole.stability
    for component in ("fx", "fy"):
        found = rest.reaction("hinge", component), whole.reaction("hinge", component)
        assert_allclose(*found, atol=1e-9)
    for question in (
        lambda: only.simulate(1.0),
        lambda: only.kinematics([0.0, 1.0]),
        lambda: only.inverse_dynamics([0.0]),
        lambda: only.equilibrium("settling"),
    ):
        with pytest.raises(AnalysisError, match=r"needs the equations of motion.*analysis='dyn"):
            question()


def test_scene_on_the_fly_has_its_derivatives(folder: Path) -> None:
    model = swing()
    scene = model.scene("all").without("motor", "rub", "spring")
    machine = load(model, scene, folder=folder)
    assert machine.mechanism.tangents.accelerations_tangent is not None
    assert (folder / "generated" / f"swing__{scene.name}__tangents.py").is_file()


def test_scene_of_a_model_file(folder: Path) -> None:
    path = folder / "file.py"
    path.write_text(
        "from codegen import Model\n\nmodel = Model('file', gravity=(0, -9.81))\n"
        "ball = model.particle('ball', mass=1.0)\n"
        "model.force('wind', on=ball, fx=2.0)\n"
        "model.scene('fall', ['gravity', 'wind'], start={ball.x: 0.0, ball.y: 0.0})\n"
    )
    from codegen.reading.model_file import read_model

    scene = read_model(path).model.scene("fall").without("wind")
    found = load(path, scene, folder=folder).simulate(1.0)
    assert found.q("ball.x")[-1] == 0.0
    assert found.q("ball.y")[-1] == pytest.approx(-9.81 / 2)


def test_scene_with_nothing_left_to_integrate(folder: Path) -> None:
    model = swing()
    model.absolute("clamp", model.bodies["bob"], "phi", -1.0)
    model.scene("clamped", extends="all", start={"bob.omega": 0.0})
    machine = load(model, model.scene("clamped").without("rub"), folder=folder)
    with pytest.raises(AnalysisError, match="nothing is left to integrate: 3 constraints hold"):
        machine.simulate(1.0)


@pytest.mark.parametrize(
    "law", [0.1 * (1 - cos(2 * t)), t**2 / 2, t**3, Piecewise((0, t < 1), ((t - 1) ** 2, True))]
)
def test_a_law_in_a_constraint_moves_a_machine_that_it_begins_at_rest(
    folder: Path, law: Expr
) -> None:
    model = Model("law_at_rest")
    bead = model.particle("bead", mass=1.0)
    model.constraint("law", bead.x - 0.3, bead.y - law)
    model.scene("run")
    machine = load(model, folder=folder)
    at = [0.0, 0.5, 1.5, 2.0]
    for r in machine.simulate(2.0, at), machine.inverse_dynamics(at), machine.kinematics(at):
        assert not r.failed
        assert r.q("bead.y") == pytest.approx([float(law.subs(t, x)) for x in at], abs=1e-9)
    assert machine.simulate(0.5, [0.5]).resume(1.5, [1.5]).q("bead.y") == pytest.approx(
        float(law.subs(t, 1.5)), abs=1e-9
    )


def test_driven_machine_says_that_nothing_was_integrated(folder: Path) -> None:
    model = swing()
    bob = model.bodies["bob"]
    model.driver("hand", bob.phi, 0.2 * t)
    model.scene("led", ["gravity"], ["hand"], start={bob.omega: 0.2})
    machine = load(model, "led", folder=folder)
    told = machine.simulate(1.0).message
    assert "3 constraints determine all 3 coordinates. inverse_dynamics" in told
    moving = load(model, model.scene("led").with_(analysis="kinematics"), folder=folder)
    with pytest.raises(AnalysisError, match="nothing to integrate"):
        moving.simulate(1.0)


def test_scene_without_a_coordinate(folder: Path) -> None:
    model = swing()
    with pytest.raises(ModelError, match="no coordinate to compute; leave one of bob in"):
        load(model, model.scene("all").without("bob"), folder=folder)
