"""The registry of elements: what is in it, what a class must answer to be."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from inspect import isfunction
from pathlib import Path
from typing import Any, ClassVar

import pytest

from codegen import Body, Model, ModelError, Point, element
from codegen.declare.element import Constraint, Effect
from codegen.elements import registry
from codegen.elements.registry import kinds_of_elements
from codegen.reference.pages import example_of
from tests.codegen.elements.drum import StringOnDrum

LIBRARY = {name: kind for name, kind in kinds_of_elements().items() if not kind.is_user_defined}


@pytest.fixture
def own_kinds(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a test registers is forgotten after it."""
    kinds_of_elements()
    monkeypatch.setattr(registry, "_KINDS", dict(registry._KINDS))
    return


def test_every_class_of_the_library_is_registered(root: Path) -> None:
    folder = root / "codegen" / "elements"
    declared = [
        (line.partition('"')[2].rpartition('"')[0], path.parent.name == "space")
        for path in folder.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.strip().startswith('kind = "')
    ]
    assert len(declared) >= 28
    assert sorted(kind for kind, in_space in declared if not in_space) == sorted(LIBRARY)
    kinds = {name: one.space for name, one in registry._KINDS.items() if not one.is_user_defined}
    assert sorted(declared) == sorted(kinds.items())


def test_roles_are_those_of_the_rooms() -> None:
    for kind in LIBRARY.values():
        assert kind.element.__module__.split(".")[2] == f"{kind.role}s"
        assert hasattr(kind.element, "forces" if kind.role == "force" else "statement")


def test_every_declaring_method_is_on_a_page() -> None:
    shown = {name for kind in LIBRARY for name in example_of(kind).methods}
    classes = (Constraint, Effect, *(kind.element for kind in LIBRARY.values()))
    declaring = {
        name
        for name in dir(Model)
        if not name.startswith("_")
        and isfunction(getattr(Model, name))
        and getattr(Model, name).__annotations__.get("return") in classes
    }
    assert declaring
    assert declaring <= shown


def test_every_kind_with_problems_has_bad_input(root: Path) -> None:
    """A row of the table of wrong declarations, or a test of its own, names it as `label` does."""
    folder = root / "tests" / "codegen"
    files = (folder / "mistakes.txt", *folder.rglob("test_*.py"))
    rows = "\n".join(path.read_text(encoding="utf-8") for path in files)
    for name, kind in LIBRARY.items():
        if kind.element.problems not in (Constraint.problems, Effect.problems):
            assert f"{name} '" in rows, f"add a row of bad input for '{name}'"


def test_page_about_new_elements_shows_the_source(root: Path) -> None:
    page = (root / "docs" / "development" / "new-element.md").read_text(encoding="utf-8")
    shown = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    sources = (
        *("codegen/elements/joints/weld.py", "codegen/model/constraints.py"),
        *("codegen/elements/forces/transmissions.py", "codegen/model/forces.py"),
        "tests/codegen/elements/test_exerted_by_bodies.py",
    )
    for snippet, source in zip(shown, sources, strict=True):
        assert snippet in (root / source).read_text(encoding="utf-8"), source


@pytest.mark.usefixtures("own_kinds")
def test_an_own_class_is_registered_and_defined_anew() -> None:
    def define() -> type:
        @element
        @dataclass(frozen=True, eq=False)
        class Tape(StringOnDrum):
            """A tape."""

            kind: ClassVar[str] = "tape"

        return Tape

    first, second = define(), define()
    assert first is not second
    assert kinds_of_elements()["tape"].element is second
    assert kinds_of_elements()["tape"].role == "joint"
    assert kinds_of_elements()["tape"].is_user_defined


@pytest.mark.usefixtures("own_kinds")
@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({}, "its kind None must be a few ASCII words"),
        ({"kind": "größe"}, "its kind 'größe' must be a few ASCII words"),
        ({"kind": "tape"}, "has no docstring"),
        ({"kind": "tape", "__doc__": "A tape."}, "lacks name, bodies, problems, potential, forces"),
        (
            {"kind": "tape", "__doc__": "A tape.", "statement": None, "name": "", "bodies": ()},
            "lacks problems; a joint or driver answers name, bodies, problems, statement",
        ),
        (
            {**vars(StringOnDrum), "kind": "weld"},
            "the kind 'weld' is that of codegen.elements.joints.weld.Weld",
        ),
    ],
)
def test_a_class_that_is_no_element_is_refused(body: dict[str, Any], words: str) -> None:
    made = {k: v for k, v in body.items() if k not in ("__dict__", "__weakref__")}
    cls = type("Tape", (), {**made, "__module__": __name__, "__qualname__": "Tape"})
    with pytest.raises(ModelError) as error:
        element(cls)
    assert "element class Tape" in error.value.problems[0]
    assert words in str(error.value)
    assert "tape" not in kinds_of_elements()


@pytest.mark.usefixtures("own_kinds")
def test_a_class_that_derives_answers_its_name_and_its_equations() -> None:
    def define(base: type, **words: Any) -> type:
        text = {"kind": "tape", "__doc__": "A tape.", "__module__": __name__}
        return element(type("Tape", (base,), text | words))

    for base, lacks in ((Constraint, "statement"), (Effect, "potential, forces")):
        with pytest.raises(ModelError, match=f"lacks {lacks};"):
            define(base, __annotations__={"name": str})
    with pytest.raises(ModelError, match="lacks name;"):
        define(Effect, forces=lambda self, bodies: {})
    model = Model("taped")
    a, b = (model.body(name, 1.0, 1.0) for name in "ab")
    fields = {"name": str, "i": Point, "j": Body, "more": tuple}
    tape = define(Effect, __annotations__=fields, pulls=lambda self, bodies: ())(
        "t", a.at(1, 2), b, (a,)
    )
    assert tape.bodies == (a, b, a)
    assert tape.problems() == []
    assert (tape.potential(()), tape.forces(())) == (None, {})
    assert kinds_of_elements()["tape"].role == "force"


@pytest.mark.usefixtures("own_kinds")
def test_a_class_that_becomes_no_dataclass_is_named() -> None:
    words = {"kind": "tape", "__doc__": "A tape.", "__module__": __name__, "more": []}
    cls = type("Tape", (Effect,), {**words, "__annotations__": {"name": str, "more": list}})
    cls.forces = lambda self, bodies: {}
    with pytest.raises(
        ModelError, match=r"element class .*Tape.* becomes no dataclass: ValueError"
    ):
        element(cls)
    with pytest.raises(ModelError, match=r"element\(driver=7\): write True or False"):
        element(driver=7)  # type: ignore[call-overload]
    with pytest.raises(ModelError, match=r"element\(7\): give a class"):
        element(driver=True)(7)  # type: ignore[arg-type]
