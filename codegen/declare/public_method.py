"""Methods that a modeller calls: called wrongly, they fail with errors of ours alone."""

from collections.abc import Callable
from functools import wraps
from inspect import isfunction, signature
from typing import Any, TypeVar

from codegen.declare.plain_values import one_line, plain_name
from codegen.errors import LinkwrightError, ModelError

Class = TypeVar("Class", bound=type[Any])


def public_method(method: Callable[..., Any], owner: str) -> Callable[..., Any]:
    """The method with text for its `name`, whose failures are `ModelError`s that say where.

    What arguments do where they are read (iterate, compare, convert) is theirs, and may fail.
    """
    about = signature(method)
    named = "name" in about.parameters

    @wraps(method)
    def call(of: Any, *arguments: Any, **words: Any) -> Any:
        if named and "name" in words:
            words["name"] = plain_name(words["name"])
        elif named and arguments:
            arguments = (plain_name(arguments[0]), *arguments[1:])
        try:
            return method(of, *arguments, **words)
        except LinkwrightError:
            raise
        except Exception as error:
            reason = f"fails with {type(error).__name__}: {one_line(error)}"
            try:
                about.bind(of, *arguments, **words)
            except TypeError as mismatch:
                reason = f"{mismatch}; it takes {about}".replace("(self, ", "(")
            name = words.get("name", arguments[0] if arguments else None) if named else None
            label = "" if name is None else f" '{name}'"
            of_whom = vars(of).get("name") if owner == "body" else None
            label += "" if of_whom is None else f" of '{plain_name(of_whom)}'"
            word = owner if method.__name__ == "__init__" else f"{owner}.{method.__name__}"
            raise ModelError(f"{word}{label}: {reason}.") from error

    return call


def public_methods(cls: Class, owner: str) -> Class:
    """The class with its own public methods bounded so."""
    for word, method in list(vars(cls).items()):
        if isfunction(method) and (word == "__init__" or not word.startswith("_")):
            setattr(cls, word, public_method(method, owner))
    return cls
