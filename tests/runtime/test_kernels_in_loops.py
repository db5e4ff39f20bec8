"""Machines whose kernels are loops run as those whose kernels are written out."""

import inspect
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import codegen
import runtime
from benchmarks.chain import SCENE, chain
from benchmarks.growth import hanging
from codegen.files.generated_modules import import_generated
from runtime import Machine

LINKS = 36  # more than 3000 operations in `accelerations`, so that it becomes loops


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    folder: Path = tmp_path_factory.mktemp("loops")
    return runtime.load(chain(LINKS), SCENE, folder=folder)


def test_the_machine_has_loops_and_a_workspace(machine: Machine) -> None:
    text = machine.path.read_text(encoding="utf-8")
    assert "for k in range(" in text
    assert "work = np.empty(" in text
    assert len(machine.parameter_values()) == machine.mechanism.description.parameter_slots


@pytest.mark.parametrize(
    ("model", "scene"),
    [("slider_crank", "compressor"), ("web_cutter", "running"), ("hard/pendulum", "bar")],
)
def test_kernels_in_loops_only_read_parameters(
    model: str, scene: str, root: Path, tmp_path: Path
) -> None:
    """Of the documented size, between numbers that no kernel may touch; the companions' as well."""
    (report,) = codegen.build(
        root / "models" / f"{model}.py", scene, tmp_path, tangents=True, reduced=True,
        unroll="never", progress=lambda _: None,
    ).scenes  # fmt: skip
    assert report.tangents
    assert report.reduced
    main, *others = (
        import_generated(x.path, x.text) for x in (report, report.tangents, report.reduced)
    )
    counts = [len(main.PARAMETERS) + len(main.CONSTANTS)] * 2
    counts.append(len(main.PARAMETERS) + len(others[1].BRANCHES) + len(others[1].CONSTANTS))
    written = set()
    for module, count in zip((main, *others), counts, strict=True):
        for name in {row[0] for row in module.OPERATIONS} - {"constants"}:
            kernel = getattr(module, name)
            around = np.random.default_rng(1).uniform(0.5, 1.5, count + 2000)
            p, before = around[1000 : 1000 + count], around.copy()
            given = [
                p if argument == "p" else 0.3 if argument == "t"
                else np.zeros(200, np.int64) if argument == "modes" else np.full(400, 0.3)
                for argument in inspect.signature(kernel.py_func).parameters
            ]  # fmt: skip
            kernel(*given)
            np.testing.assert_array_equal(around, before, err_msg=name)
            written.add(name)
    assert {"accelerations", "correction", "accelerations_tangent", "expand"} <= written


def test_threads_that_share_parameters_get_the_same_accelerations(machine: Machine) -> None:
    kernel, p, modes = machine.kernels.accelerations, machine.parameter_values(), np.zeros(0, int)
    n, m = len(machine.coordinates), len(machine.constraints)

    @numba.njit(nogil=True)
    def many(q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> None:
        for k in range(len(q)):
            kernel(0.0, q[k], v[k], p, modes, a[k], lam)

    q, v = np.random.default_rng(2).normal(size=(2, 4000, n))
    arrays = [(q, v, p, modes, np.zeros((len(q), n)), np.zeros(m)) for _ in range(3)]
    many(*arrays[0])
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda given: many(*given), arrays[1:]))
    for other in arrays[1:]:
        np.testing.assert_array_equal(other[4], arrays[0][4])


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_long_chain_swings_as_its_own_equations_say(machine: Machine, method: str) -> None:
    result = machine.simulate(2.0, method=method, rtol=1e-9, atol=1e-9, progress=False)
    angles = [float(result.q(f"link_{k}.phi")[-1]) for k in range(LINKS)]
    assert np.abs(np.array(angles) - hanging(LINKS)).max() < 1e-6
