"""The kinds of elements: each joint, driver and force is registered under its `kind`.

The library's classes register themselves where they are defined, and a user's own do it in the
same way in the user's file; nothing that is done with a kind asks who wrote it.
"""

import importlib
import pkgutil
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from inspect import cleandoc
from typing import Any, Literal, TypeVar, dataclass_transform, overload

from codegen.declare.element import Constraint, Effect
from codegen.declare.element_fields import direction, ground_unless_given, quantity
from codegen.errors import ModelError
from codegen.readers.calls import declaring, failure
from codegen.readers.values import is_flag, shown

Role = Literal["joint", "driver", "force"]
Class = TypeVar("Class", bound=type[Any])

LIBRARY = "codegen.elements"
WORDS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ -]*")
SHARED = ("name", "bodies", "problems")
CONSTRAINT = (*SHARED, "statement")
EFFECT = (*SHARED, "potential", "forces")
ACTIONS = ("potential", "forces", "pulls", "friction", "reported")
"""One of these an effect answers itself; the others it may inherit."""


@dataclass(frozen=True)
class Kind:
    """A registered class of elements, `name` being its `kind`."""

    name: str
    role: Role
    element: type[Any]
    space: bool = False  # whether it belongs to machines in space alone

    @property
    def text(self) -> str:
        """The docstring of the class, without its indentation."""
        return _docstring(self.element)

    @property
    def summary(self) -> str:
        """The docstring's first sentence, on one line."""
        return " ".join(self.text.partition("\n\n")[0].split())

    @property
    def is_user_defined(self) -> bool:
        """Whether a user wrote it, and not the library."""
        return not _of_library(self.element)


_KINDS: dict[str, Kind] = {}


@overload
def element(cls: Class, /) -> Class: ...
@overload
def element(*, driver: bool = False, space: bool = False) -> Callable[[Class], Class]: ...
@dataclass_transform(
    eq_default=False, frozen_default=True,
    field_specifiers=(quantity, direction, ground_unless_given, field),
)  # fmt: skip
@declaring("element")
def element(
    cls: type[Any] | None = None, /, *, driver: bool = False, space: bool = False
) -> type[Any] | Callable[[type[Any]], type[Any]]:
    """Register a class of joints, drivers or forces under its `kind`; a class decorator.

    The class becomes ``@dataclass(frozen=True, eq=False)``, unless it has an ``__init__`` already.

    Parameters
    ----------
    cls
        A class with a docstring and the members of `Constraint` (`kind`, `name`, `bodies`,
        `problems()`, `statement()`) or of `Effect` (`potential()` and `forces()` in place of
        `statement()`). A subclass of either inherits all but `kind`, `name` and `statement()`.
    driver
        Whether its equations prescribe a motion: ``@element(driver=True)``.
    space
        Whether it belongs to machines in space alone; all of these have one page.

    Raises
    ------
    ModelError
        If the class lacks any of these, or has the kind of another one.

    Notes
    -----
    A user's class that is defined again, as by a cell of a notebook that runs again, replaces the
    earlier class.
    """
    if not is_flag(driver):
        raise ModelError(f"element(driver={shown(driver)}): write True or False.")

    def register(cls: type[Any]) -> type[Any]:
        if not _of_library(cls):
            _load()  # so that the library's kinds are taken
        problems = _problems(cls)
        if problems:
            raise ModelError(problems)
        if not any("__init__" in vars(c) for c in _own_classes(cls)):
            try:
                cls = dataclass(frozen=True, eq=False)(cls)
            except (TypeError, ValueError) as error:
                where = f"element class {cls.__qualname__}"
                raise ModelError(f"{where} becomes no dataclass: {failure(error)}.") from error
        role: Role = "driver" if driver else "joint" if hasattr(cls, "statement") else "force"
        _KINDS[cls.kind] = Kind(cls.kind, role, cls, space)
        return cls

    return register if cls is None else register(cls)


def kinds_of_elements(*, space: bool = False) -> dict[str, Kind]:
    """Kinds in the plane, or in space: the library's by their roles and names, then a user's."""
    _load()
    roles = ("joint", "driver", "force")
    ordered = sorted(
        _KINDS.values(), key=lambda k: (k.is_user_defined, roles.index(k.role), k.name)
    )
    return {kind.name: kind for kind in ordered if kind.space == space}


def role(kind: str) -> Role | None:
    """The role of a registered kind; None for one that is not."""
    return _KINDS[kind].role if kind in _KINDS else None


@cache
def _load() -> None:
    """Import all modules of the library's elements, which registers them."""
    package = importlib.import_module(LIBRARY)
    for info in pkgutil.walk_packages(package.__path__, f"{LIBRARY}."):
        importlib.import_module(info.name)


def _own_classes(cls: type[Any]) -> list[type[Any]]:
    """The class and its bases, without `object` and the protocols."""
    return [c for c in cls.__mro__[:-1] if not getattr(c, "_is_protocol", False)]


def _of_library(cls: type[Any]) -> bool:
    return str(getattr(cls, "__module__", "")).startswith(f"{LIBRARY}.")


def _docstring(cls: type[Any]) -> str:
    """What its author wrote; "" where dataclasses wrote one, or nobody."""
    text = cls.__doc__ or ""
    return "" if text.startswith(f"{cls.__name__}(") else cleandoc(text)


def _problems(cls: type[Any]) -> list[str]:
    given: object = cls
    if not isinstance(given, type):
        return [f"element({shown(given)}): give a class; @element stands above one."]
    where, kind = f"element class {cls.__qualname__}", getattr(cls, "kind", None)
    if not isinstance(kind, str) or not WORDS.fullmatch(kind):
        return [f'{where}: its kind {shown(kind)} must be a few ASCII words: kind = "belt".']
    problems = []
    if not _docstring(cls) and sys.flags.optimize < 2:  # python -OO takes docstrings away
        problems.append(f"{where} has no docstring; say in one sentence what it holds or exerts.")
    own = _own_classes(cls)
    declared = {word for c in own for word in (*vars(c), *vars(c).get("__annotations__", ()))}
    if Constraint in cls.__mro__ or Effect in cls.__mro__:
        declared |= {"bodies", "problems"}
    if Effect in cls.__mro__ and declared & {*ACTIONS}:
        declared |= {"potential", "forces"}
    required = CONSTRAINT if "statement" in declared or Constraint in cls.__mro__ else EFFECT
    if missing := [word for word in required if word not in declared]:
        problems.append(
            f"{where} lacks {', '.join(missing)}; a joint or driver answers "
            f"{', '.join(CONSTRAINT)}, a force {', '.join(EFFECT)}."
        )
    taken = _KINDS.get(kind)
    if taken and (_of_library(cls) or not taken.is_user_defined):
        home = f"{taken.element.__module__}.{taken.element.__qualname__}"
        if home != f"{cls.__module__}.{cls.__qualname__}":  # not the same definition, met again
            problems.append(f"{where}: the kind '{kind}' is that of {home}; give another.")
    return problems
