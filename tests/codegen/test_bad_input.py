"""What is wrong with a model is said by name, all of it at once, and nothing is written."""

import pickle
from pathlib import Path
from typing import Any

import pytest

from codegen import LinkwrightError
from tests.codegen.complaints import check, complaints


def test_constraints_that_contradict_one_another(tmp_path: Path) -> None:
    text = "model.absolute('A', a, 'phi', 0.5)\nmodel.driver('d', a.phi, 0.5 + t)"
    check(complaints(tmp_path, text), [r"redundant: d\.phi \(driver\). Remove or relax 'd'"])


def test_all_problems_come_at_once_by_both_doors(tmp_path: Path) -> None:
    text = """
c = model.body("c", mass=-1.0, inertia=2.0)
model.force("f", on=model.ground, fx=Symbol("z"))
model.scene("s", ["nothing"], start={"q.x": 1})
"""
    expected = ["mass of body 'c'", "force 'f' acts", "unknown symbol 'z'", "no effect", "'q.x'"]
    check(complaints(tmp_path, text), expected)


@pytest.mark.parametrize("arguments", [(), ("a",), ("a", 1), (("a", "b"),)])
def test_base_of_all_errors_takes_what_an_exception_takes(arguments: tuple[Any, ...]) -> None:
    error = LinkwrightError(*arguments)
    assert pickle.loads(pickle.dumps(error)).args == error.args
    assert ("a" in str(error)) == bool(arguments)
