"""What is infinite or no number is refused, or ends a run, with the name of its element."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from sympy import Rational

from codegen import Model, t
from codegen.declare.body import Body
from codegen.errors import AssemblyError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result


def machine(folder: Path, name: str, declare: Callable[[Model, Body], Any]) -> Machine:
    """A particle with another effect that is sound, an innocent joint, and what is declared."""
    model = Model(name)
    bead = model.particle("bead", mass=1.0)
    model.absolute("rail", bead, "y", 0)
    model.force("sound", bead, fx=0.1)
    declare(model, bead)
    return load(model, folder=folder)


def run(folder: Path, name: str, declare: Callable[[Model, Body], Any], end: float) -> Result:
    return machine(folder, name, declare).simulate(end, np.linspace(0, end, 5), progress=False)


LAWS = {
    "root": (t**0.5, "velocity ν", "inf"),
    "cube root": (t ** Rational(1, 3), "velocity ν", "inf"),
    "three halves": (t**1.5, "acceleration γ", "inf"),
    "pole": (1 + 1 / t, "equation Φ", "-inf"),
    "logarithm": (sympy.log(t - 1), "equation Φ", "nan"),
}


@pytest.mark.parametrize("word", LAWS)
def test_a_law_that_is_infinite_at_the_start_is_refused(workshop: Path, word: str) -> None:
    law, part, value = LAWS[word]
    made = machine(
        workshop, f"law_{word.replace(' ', '_')}", lambda m, p: m.driver("drive", p.x, law)
    )
    with pytest.raises(AssemblyError) as error:
        made.simulate(1.0, progress=False)
    (problem,) = error.value.problems
    assert f"the {part} of driver 'drive' is {value} at t = 0 s" in problem
    assert "rail" not in problem


def test_a_constraint_with_an_infinite_slope_is_refused(workshop: Path) -> None:
    made = machine(
        workshop, "slope", lambda m, p: m.constraint("curve", p.x ** Rational(1, 3) - p.y)
    )
    with pytest.raises(AssemblyError, match="derivative Φ_q of constraint 'curve' is inf"):
        made.assemble()


FORCES = {
    "inverse": lambda m, p: m.force("push", p, fx=1 / p.x),
    "potential": lambda m, p: m.potential("push", p.x ** Rational(1, 3)),
    "spring": lambda m, p: m.spring("push", m.ground, p, 5.0, free_length=1.0),
    "root": lambda m, p: m.force("push", p, fx=sympy.sqrt(-1 - p.x**2)),
    "logarithm": lambda m, p: m.force("push", p, fx=sympy.log(-1 - p.x**2)),
    "arc": lambda m, p: m.force("push", p, fx=sympy.acos(2 + sympy.Abs(p.x))),
}


@pytest.mark.parametrize("word", FORCES)
def test_a_force_that_is_infinite_or_not_real_is_named(workshop: Path, word: str) -> None:
    result = run(workshop, f"force_{word}", FORCES[word], 1.0)
    assert result.outcome is Outcome.NOT_FINITE
    assert "the force of 'push' along bead.x" in result.message.replace("The", "the")
    assert "sound" not in result.message
    assert_allclose(result.t[-1], 0.0, atol=1e-9)


def test_a_force_of_time_that_ends_is_named(workshop: Path) -> None:
    """The instant is known beforehand: the function of time ends, and not the accelerations."""
    result = run(
        workshop, "root_of_time", lambda m, p: m.force("push", p, fx=sympy.sqrt(1 - 2 * t)), 1.0
    )
    assert result.outcome is Outcome.DISCONTINUOUS
    assert "A function of time in 'push' has no finite value at t = 0.5 s" in result.message
    assert "sound" not in result.message
    assert_allclose(result.t[-1], 0.5, atol=1e-9)
    whole = result.t[:-1]
    assert_allclose(result.a("bead.x")[:-1], 0.1 + np.sqrt(1 - 2 * whole), rtol=1e-12)


@pytest.mark.parametrize("exponent", [2.5, 3.5, Rational(7, 3)])
def test_a_law_with_a_broken_power_starts_at_zero(workshop: Path, exponent: float) -> None:
    e = float(exponent)
    name = f"broken_{round(10 * e)}"
    result = run(workshop, name, lambda m, p: m.driver("drive", p.x, t**exponent), 1.0)
    assert result.outcome is Outcome.OK
    assert_allclose(result.q("bead.x"), result.t**e, atol=1e-9)
    assert_allclose(result.a("bead.x"), e * (e - 1) * result.t ** (e - 2), atol=1e-9)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_central_potential_passes_its_centre(workshop: Path, method: Any) -> None:
    def declare(model: Model, bead: Body) -> None:
        model.potential("bowl", (bead.x**2 + bead.y**2) ** Rational(3, 2))
        model.scene("swing", ["bowl"], start={bead.x: 0.0, bead.vx: 1.0})

    result = machine(workshop, "bowl", declare).simulate(
        3.0, np.linspace(0, 3, 31), rtol=1e-9, method=method, progress=False
    )
    assert result.outcome is Outcome.OK
    assert result.a("bead.x")[0] == 0.0
    assert_allclose(result.energy(), 0.5, rtol=1e-7)
    assert (result.q("bead.x") < 0).any()
