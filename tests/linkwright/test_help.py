"""What `help` and a notebook's completion show of public names: signatures that a person reads."""

import inspect
import pydoc
import re
from collections.abc import Iterator
from typing import Any

import pytest

import linkwright as lw
from runtime.core.kernel_abi import KERNELS, SIGNATURES, Kernels

OF_PYTHON = {"Constraint", "Effect", "Outcome"}  # protocols and enumerations: Python's own
CLASSES = [name for name in dir(lw) if inspect.isclass(getattr(lw, name))]
UNREADABLE = re.compile(r"\bat 0x|object object|\*args, \*\*kwargs|\w\.\w|_typing|ForwardRef")


def public() -> Iterator[tuple[str, Any]]:
    """Every public function, class and method of a class."""
    for name in dir(lw):
        value = getattr(lw, name)
        if inspect.isfunction(value):
            yield name, value
        elif inspect.isclass(value) and name not in OF_PYTHON:
            for word in dir(value):
                method = inspect.getattr_static(value, word)
                home = str(getattr(method, "__module__", ""))
                library = home.startswith(("codegen.", "runtime."))
                if inspect.isfunction(method) and library and not word.startswith("_"):
                    yield f"{name}.{word}", method


CALLABLES = dict(public())


def test_there_are_many() -> None:
    assert {"Machine.simulate", "Model.scene", "Result.series", "load", "build"} < set(CALLABLES)
    assert len(CALLABLES) > 60


@pytest.mark.parametrize("name", CALLABLES)
def test_signature_is_readable(name: str) -> None:
    text = re.sub(r"\b\d+\.\d+|e[-+]\d+|'[^']*'", "", str(inspect.signature(CALLABLES[name])))
    assert not UNREADABLE.search(text), text


@pytest.mark.parametrize("name", CLASSES)
def test_signature_of_a_class_is_readable(name: str) -> None:
    text = re.sub(r"\b\d+\.\d+|e[-+]\d+|'[^']*'", "", str(inspect.signature(getattr(lw, name))))
    assert not UNREADABLE.search(text), text


@pytest.mark.parametrize("base", [lw.Effect, lw.Constraint])
def test_a_base_of_elements_takes_nothing_and_says_what_to_do(base: Any) -> None:
    assert str(inspect.signature(base)) == "()"
    with pytest.raises(lw.ModelError, match=f"{base.__name__} is a base class and has no equat"):
        base("air", 1.0)


@pytest.mark.parametrize("name", CALLABLES)
def test_help_says_what_it_is(name: str) -> None:
    assert inspect.getdoc(CALLABLES[name])


@pytest.mark.parametrize("word", ["simulate", "kinematics", "inverse_dynamics", "equilibrium"])
def test_help_of_an_analysis_names_every_argument(word: str) -> None:
    method = getattr(lw.Machine, word)
    text = inspect.getdoc(method) or ""
    listed = re.findall(r"^(\w+(?:, \w+)*)$", text, re.MULTILINE)
    arguments = {name.strip() for line in listed for name in line.split(",")}
    assert set(inspect.signature(method).parameters) - {"self"} <= arguments
    assert "Examples\n--------\n>>> " in text


def test_help_of_simulate_is_a_page() -> None:
    text = pydoc.plain(pydoc.render_doc(lw.Machine.simulate))
    assert "t_eval: ArrayLike | " in text
    assert "rtol: float | None = None" in text
    assert ">>> " in text


def test_help_of_the_kernels_has_arguments_and_shapes() -> None:
    text = pydoc.plain(pydoc.render_doc(Kernels))
    for name in KERNELS:
        assert re.search(rf"^ \|  {name}\(", text, re.MULTILINE), name
    for shape in ("q, v, a", "(n,)", "(m,)", "modes", "(s,) int64", "row-major"):
        assert shape in text


def test_the_kernels_of_the_help_are_those_that_there_are() -> None:
    written = dict(re.findall(r"^(\w+)\(([\w, ]+)\)", inspect.getdoc(Kernels) or "", re.MULTILINE))
    written = {k: x for k, x in written.items() if k in KERNELS}
    assert set(written) == set(KERNELS)
    for name, arguments in written.items():
        assert len(arguments.split(", ")) == len(SIGNATURES[name].args), name


def test_the_class_of_space_shows_its_methods() -> None:
    text = pydoc.render_doc(lw.SpaceModel.universal, renderer=pydoc.plaintext)
    assert "universal(self, name" in text
    assert "help(lw.SpaceModel)" in str(lw.Model.__doc__)
    assert type(lw.SpaceModel("m")) is type(lw.Model("m", space=True))
    assert not lw.SpaceModel("m").problems
    wrong: Any = 1
    told = ("model 'm': space=1; write True or False.",)
    assert lw.SpaceModel("m", space=wrong).problems == told
