"""`import linkwright as lw` has what codegen and runtime make public, and loads it when needed."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import codegen
import linkwright
import runtime
from codegen import errors


def fresh(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_name_has_all_that_is_public_and_no_more() -> None:
    public = {*codegen.__all__, *runtime.__all__}
    assert len(public) == len(codegen.__all__) + len(runtime.__all__)
    assert set(dir(linkwright)) == set(linkwright.__all__) == public
    for name in codegen.__all__:
        assert getattr(linkwright, name) is getattr(codegen, name)
    for name in runtime.__all__:
        assert getattr(linkwright, name) is getattr(runtime, name)
    named = {"Model", "load", "t", "Body", "Constraint", "Effect", "element", "Result", "Event"}
    assert named < public


def test_every_error_is_public() -> None:
    kinds = {
        name
        for name, value in vars(errors).items()
        if inspect.isclass(value) and issubclass(value, errors.LinkwrightError)
    }
    assert len(kinds) > 10
    assert kinds < set(dir(linkwright))


def test_public_names_and_lazy_homes_agree() -> None:
    assert set(runtime._HOMES) == set(runtime.__all__)
    assert set(codegen._HOMES) - {"declared_picture", "scene_equations"} < set(codegen.__all__)


def test_what_is_not_there_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="module 'linkwright' has no attribute 'laod'"):
        linkwright.laod  # noqa: B018
    with pytest.raises(AttributeError, match="did you mean 'Model'"):
        linkwright.Modle  # noqa: B018


def test_what_the_documents_name_is_there() -> None:
    for name in ("Measure", "SPEED", "TableWarning"):
        assert getattr(linkwright, name) is not None


def test_a_star_import_binds_every_name(tmp_path: Path) -> None:
    done = fresh(
        "from linkwright import *\nimport linkwright\n"
        "print(all(n in globals() for n in dir(linkwright)))",
        tmp_path,
    )
    assert done.stdout.strip() == "True", done.stderr


@pytest.mark.parametrize("name", ["codegen", "runtime"])
def test_a_file_of_the_users_does_not_stand_for_a_package(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file')")
    done = fresh("import linkwright as lw\nprint(lw.load, lw.InputError)", tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["codegen", "runtime"])
def test_a_module_that_took_the_name_before_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").touch()
    done = fresh(f"import {name}\nimport linkwright", tmp_path)
    assert done.returncode == 1
    assert f"{name}.py was imported by that name before; rename that file" in done.stderr
