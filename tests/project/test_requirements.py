"""pyproject.toml, the lock and the lower bounds agree."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

import codegen
from benchmarks.contest import PEERS

COMPANIONS = {"pyparsing"}  # required by matplotlib, not by us; its oldest needs an old one
LOCKED_ALONE = {"docs"}  # extras that no test needs, always installed in the locked versions


@pytest.fixture(scope="module")
def project(root: Path) -> dict[str, Any]:
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def requirements(project: dict[str, Any]) -> dict[str, SpecifierSet]:
    """All that the project requires of others, extras included but the tools to measure beside."""
    lines = [*project["dependencies"]]
    for name, extra in project["optional-dependencies"].items():
        lines += extra if name != "bench" else []
    parsed = [Requirement(line) for line in lines]
    return {
        canonicalize_name(entry.name): entry.specifier
        for entry in parsed
        if entry.name != project["name"]
    }


def pins(path: Path) -> dict[str, Version]:
    lines = [
        line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")
    ]
    unpinned = [line for line in lines if not re.fullmatch(r"[\w.-]+==[\w.!+]+", line)]
    assert not unpinned, f"{path.name}: not of the form name==version: {unpinned}"
    pairs = [line.split("==") for line in lines]
    return {canonicalize_name(name): Version(version) for name, version in pairs}


def test_lower_bounds_are_those_that_are_tested(
    root: Path, project: dict[str, Any], requirements: dict[str, SpecifierSet]
) -> None:
    oldest = pins(root / "constraints-oldest.txt")
    locked = {
        canonicalize_name(Requirement(line).name)
        for extra in LOCKED_ALONE
        for line in project["optional-dependencies"][extra]
    }
    lower = {
        name: str(next(one for one in bounds if one.operator == ">="))
        for name, bounds in requirements.items()
        if name not in locked
    }
    assert lower == {
        name: f">={version}" for name, version in oldest.items() if name not in COMPANIONS
    }


def test_the_lock_has_a_version_of_everything(
    root: Path, requirements: dict[str, SpecifierSet]
) -> None:
    lock = pins(root / "constraints.txt")
    assert not requirements.keys() - lock.keys()
    assert not [name for name, bound in requirements.items() if lock[name] not in bound]


def test_all_extras_are_in_all(project: dict[str, Any]) -> None:
    extras = project["optional-dependencies"]
    (everything,) = extras["all"]
    assert Requirement(everything).extras == extras.keys() - {"all", "bench"} - LOCKED_ALONE


def test_the_tools_to_measure_beside_are_those_of_the_contest(project: dict[str, Any]) -> None:
    lines = project["optional-dependencies"]["bench"]
    extra = {canonicalize_name(Requirement(line).name) for line in lines}
    asked = {package for peer in PEERS.values() for package in peer.package.split()}
    own = {canonicalize_name(Requirement(line).name) for line in project["dependencies"]}
    # numbalsoda has no wheels: with it, the extra would ask for a Fortran compiler.
    assert asked - own - {"numbalsoda"} == extra - {project["name"]}


def test_version_is_stated_once(project: dict[str, Any]) -> None:
    assert project["version"] == codegen.__version__


def test_supported_pythons_are_named(project: dict[str, Any]) -> None:
    named = [
        match[1] for entry in project["classifiers"] if (match := re.search(r":: (3\.\d+)$", entry))
    ]
    supported = SpecifierSet(project["requires-python"])
    assert named[0] == "3.11"
    assert all(version in supported for version in named)
    assert "3.10" not in supported
