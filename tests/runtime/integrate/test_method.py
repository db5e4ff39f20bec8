"""The register of methods, and a method that is none of the library's: one file, one entry."""

import json
import subprocess
import sys

import pytest

from codegen.emit.runge_kutta import module_text
from codegen.tableaus.tableau import Tableau, difference, stages, weights
from runtime.integrate.method import (
    EXPLICIT,
    IMPLICIT,
    LEADING,
    METHODS,
    REGISTER,
    alternatives,
    find_method,
)
from runtime.integrate.wiring import function_table

# K. Heun's method with Euler's as the embedded one, which is not worth a place in the library.
B = weights("1/2 1/2")
SMALL = Tableau(
    about="Order 2(1).", order=2, error_order=1, stages=stages("1 | 1"),
    b=B, error=difference(B, weights("1")), dense_order=2, dense=(),
    beta=0.04, safety=0.9, shrink=0.2, grow=10.0,
)  # fmt: skip

# A fresh process, as the names of all methods are fixed when the register is imported.
NEWCOMER = """
import json
import numpy as np
from runtime.integrate import method

method.REGISTER["small"] = method.Registration("small", method.RUNGE_KUTTA, 2)
method.METHODS = tuple(method.REGISTER)
method.EXPLICIT = (*method.EXPLICIT, "small")

from runtime.studies import pictures
from runtime.studies import reference
from runtime.dynamics.formulations import FORMULATIONS
from runtime.studies.harness import all_settings
from tests.runtime.integrate.systems import relay, run_relay

errors = []
for count in (160, 320):
    r = run_relay(relay(stiffness=4.0), 1.0, 0.0, 4.0, method="small", fixed_step=4.0 / count,
                  t_eval=np.linspace(0.0, 4.0, 101))
    errors.append(float(np.abs(r.q[:, 0] - np.cos(2.0 * r.t)).max()))
free = run_relay(relay(stiffness=4.0), 1.0, 0.0, 4.0, method="small", tolerance=1e-6)
print(json.dumps({
    "errors": errors,
    "free": float(np.abs(free.q[:, 0] - np.cos(2.0 * free.t)).max()),
    "rejected": free.statistics.rejected,
    "colour": pictures.METHOD_COLOURS["small"],
    "settings": [s.formulation for s in all_settings(method.METHODS, FORMULATIONS)
                 if s.method == "small"],
    "witnesses": [s.method for s in reference._FIRST],
}))
"""


@pytest.fixture(scope="module")
def newcomer(root, tmp_path_factory):
    """What the library makes of a new method, without any other change."""
    folder = tmp_path_factory.mktemp("newcomer")
    (folder / "small.py").write_text(module_text("small", SMALL), encoding="utf-8")
    code = f"import sys; sys.path[:0] = [{str(root)!r}, {str(folder)!r}]\n{NEWCOMER}"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_new_method_integrates_with_its_order(newcomer):
    coarse, fine = newcomer["errors"]
    assert 3.5 < coarse / fine < 4.5
    assert newcomer["free"] < 1e-4
    assert newcomer["rejected"] < 20


def test_a_new_method_is_compared_with_the_others(newcomer):
    assert newcomer["colour"].startswith("#")
    assert newcomer["settings"] == ["cartesian", "reduced"]


def test_a_method_of_low_order_confirms_no_reference(newcomer):
    assert set(newcomer["witnesses"]) == {"dop853", "dopri5", "radau5"}


def test_generated_methods_are_found_beside_a_package_of_that_name(root, tmp_path):
    # The folder `generated` of a user who made it a package hides the library's.
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "__init__.py").touch()
    code = (
        f"import sys; sys.path[:0] = ['', {str(root)!r}]; import generated\n"
        "from runtime.integrate.method import find_method; print(find_method('dop853').last)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == "12", done.stderr


def test_register():
    assert set(METHODS) == {*EXPLICIT, *IMPLICIT}
    assert max(REGISTER[name].order for name in EXPLICIT) == REGISTER[LEADING].order
    assert alternatives(("a", "b", "c")) == "a, b or c"


@pytest.mark.parametrize("name", METHODS)
def test_every_method_is_complete(name):
    method = find_method(name)
    assert function_table(name).all()
    assert method.nodes[0] == 0.0
    assert max(method.nodes) == 1.0
    assert 0.0 < method.shrink < method.safety < 1.0 < method.grow
    floats, integers = method.memory(3)
    assert (floats > 0 and integers > 0) or not REGISTER[name].implicit
