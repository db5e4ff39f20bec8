"""Constraints in pieces of coordinates: steps end where they meet; slopes that jump are named."""

from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from codegen import Model, t
from codegen.errors import ModelError
from runtime import load

G = 9.81
x = sp.Symbol("x", real=True)
TRACKS = {
    "odd_square": x * sp.Abs(x),
    "floor_into_bowl": sp.Piecewise((0, x < 0), (x**2, True)),
    "ramp_with_a_fillet": sp.Piecewise((0, x < 0.1), ((x - 0.1) ** 2, x < 0.6), (x - 0.35, True)),
    "power_of_a_largest": 0.5 * sp.Max(0, x - 0.2) ** 2,
}


def model_of(name: str, track: sp.Expr) -> Model:
    model = Model(f"pieces_{name}", gravity=(0, -G))
    bead = model.particle("bead", mass=2.0)
    model.constraint("track", bead.y - track.subs(x, bead.x))
    model.scene("run", ["gravity"], start={bead.x: -1, bead.vx: 4})
    model.driver("pull", bead.x, t - 1)
    model.scene("driven", ["gravity"], drivers=["pull"])
    return model


@pytest.mark.parametrize("name", TRACKS)
def test_bead_on_a_track_in_pieces(workshop: Path, name: str) -> None:
    track = TRACKS[name].rewrite(sp.Piecewise)
    slope, bend = (sp.lambdify(x, sp.diff(track, x, order)) for order in (1, 2))

    def motion(_: float, y: np.ndarray) -> list[float]:
        f, c = float(slope(y[0])), float(bend(y[0]))
        return [y[1], -f * (G + c * y[1] ** 2) / (1 + f * f)]

    due = solve_ivp(motion, (0.0, 1.0), [-1.0, 4.0], rtol=1e-12, atol=1e-13, max_step=1e-3).y
    model = model_of(name, TRACKS[name])
    machine = load(model, "run", folder=workshop)
    for formulation in ("cartesian", "reduced"):
        run = machine.simulate(1.0, formulation=formulation, rtol=1e-11)
        assert run.outcome.name == "OK"
        assert not run.events
        assert abs(run.q("bead.x")[-1] - due[0, -1]) < 2e-9
        assert abs(run.v("bead.x")[-1] - due[1, -1]) < 2e-8
        assert np.ptp(run.energy()) < 1e-8
    instants = np.linspace(0.05, 1.95, 20)
    driven = load(model, "driven", folder=workshop).inverse_dynamics(instants)
    np.testing.assert_allclose(driven.a("bead.y"), [bend(at - 1) for at in instants], atol=1e-9)


@pytest.mark.parametrize(
    "track",
    [sp.Abs(x), sp.Piecewise((0, x < 0), (x, True)), sp.Piecewise((0, x < 0), (1 + x**2, True)),
     sp.Abs(x) ** 1.5, sp.Max(0, x) ** 2 + sp.floor(x), sp.Max(0, x) ** 2 * sp.exp(x)],
)  # fmt: skip
def test_slopes_that_jump_are_refused(workshop: Path, track: sp.Expr) -> None:
    with pytest.raises(ModelError, match=r"constraint 'track': .*(kink|nothing may switch)"):
        load(model_of("refused", track), "run", folder=workshop)


def test_other_terms_are_looked_into(workshop: Path) -> None:
    """Beside pieces the law's rate jumps at 0.4, and the cut is come to at 1, by name."""
    law = sp.Piecewise((0, t < 0.4), (t - 0.4, True))
    machine = load(model_of("beside", sp.Max(0, x) ** 2 + law), "run", folder=workshop)
    (jump,) = machine.simulate(1.0).events
    assert jump.time == pytest.approx(0.4, abs=1e-12)
    cut = load(model_of("cut", sp.Max(0, x) ** 2 + sp.atan2(x, -1)), "driven", folder=workshop)
    assert "atan2(bead_x, -1) comes to its cut" in cut.kinematics(np.linspace(0, 2, 11)).message
