"""Random machines in reduced coordinates: a sample of `tests.random_mechanisms.reduced_runs`."""

from pathlib import Path

import numpy as np

from codegen.errors import AssemblyError
from codegen.generated_files.generated_file import write_if_changed
from runtime import load
from tests.random_mechanisms import Scales, random_mechanism
from tests.random_mechanisms.reduced_runs import Comparison, compare, compare_runs

FOUR_BAR = """
from codegen import Model

model = Model("any_four_bar", gravity=(0, -9.81))
a, b, c, d = (model.parameter(n, x, unit="m", sign="positive")
              for n, x in dict(a=1.0, b=2.0, c=1.5, d=2.2).items())
crank, coupler, rocker = (model.body(n, mass=1.0, inertia=0.1) for n in ("crank", "bar", "rocker"))
model.revolute("O", model.ground.at(0, 0), crank.at(0, 0))
model.revolute("A", crank.at(a, 0), coupler.at(0, 0))
model.revolute("B", coupler.at(b, 0), rocker.at(c, 0))
model.revolute("D", model.ground.at(d, 0), rocker.at(0, 0))
model.scene("run", ["gravity"], start={crank.phi: 1.0, crank.omega: 2.0},
            guess={coupler.phi: 0.2, rocker.phi: 1.5})
"""


def test_a_mechanism_of_several_loops_passes_dead_centres(workshop: Path) -> None:
    found = compare(random_mechanism(9, scales=Scales()), 4.0, workshop)
    assert found.verdict == "ok", str(found)
    assert found.changes > 0
    assert found.reached > 2.0


def test_four_bars_of_any_lengths_pass_dead_centres(workshop: Path) -> None:
    path = workshop / "models" / "any_four_bar.py"
    write_if_changed(path, FOUR_BAR)
    machine = load(path, "run", folder=workshop)
    random, found = np.random.default_rng(5), list[Comparison]()
    while len(found) < 10:
        lengths = {name: float(random.uniform(0.4, 2.0)) for name in "abcd"}
        try:
            found.append(compare_runs(machine, str(lengths), 10.0, lengths))
        except AssemblyError:
            continue
    assert [str(one) for one in found if one.verdict != "ok"] == []
    assert sum(one.changes > 0 for one in found) > 5
