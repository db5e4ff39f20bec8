"""Public functions, methods and classes: called wrongly, they say what they take.

A wrong call names the callable, what it takes and what was given; an attribute that an object does
not have is answered with those that are spelt alike. Signatures are shown as a person reads them.
"""

import re
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import wraps
from inspect import Parameter, formatannotation, isfunction, signature
from typing import Any, TypeVar

from codegen.errors import InputError, LinkwrightError, ModelError, NoAttributeError
from codegen.readers.failures import failure
from codegen.readers.values import one_line, shown

Class = TypeVar("Class", bound=type[Any])
Function = TypeVar("Function", bound=Callable[..., Any])
_SHOWN = 40  # layout: characters of an argument in a message


def wrong_call(
    title: str, function: Callable[..., Any], mismatch: object, arguments: tuple[Any, ...],
    words: Mapping[str, Any],
) -> str:  # fmt: skip
    """What a callable takes, and what it was given instead."""
    known = signature(function).parameters
    takes = ", ".join(_written(p) for p in known.values() if p.name != "self")
    given = [shown(a, _SHOWN) for a in arguments]
    given += [f"{one_line(k, _SHOWN)}={shown(v, _SHOWN)}" for k, v in words.items()]
    text = f"{title}: {one_line(mismatch)}; it takes ({takes}), and was given ({', '.join(given)})."
    near = [
        f"{one_line(word, _SHOWN)}: did you mean {found[0]}?"
        for word in words
        if word not in known and (found := get_close_matches(word, known, n=1))
    ]
    return " ".join([text, *near])


def _written(parameter: Parameter) -> str:
    stars = {"VAR_POSITIONAL": "*", "VAR_KEYWORD": "**"}.get(parameter.kind.name, "")
    default = parameter.default
    tail = "" if default is Parameter.empty or callable(default) else f"={shown(default, _SHOWN)}"
    return f"{stars}{parameter.name}{tail}"


def _guarded(
    function: Callable[..., Any], title: Callable[[tuple[Any, ...], Mapping[str, Any]], str],
    error: type[InputError], is_ours: bool,
) -> Callable[..., Any]:  # fmt: skip
    """The callable, which says what it takes where its arguments do not fit its signature.

    Where it `is_ours` to answer, all else that fails in it is told by the same title.
    """
    about = signature(function)
    own = int(next(iter(about.parameters), "") == "self")  # arguments before those of the caller

    @readable
    @wraps(function)
    def call(*arguments: Any, **words: Any) -> Any:
        try:
            return function(*arguments, **words)
        except LinkwrightError:
            raise
        except Exception as raised:
            try:
                about.bind(*arguments, **words)
            except TypeError as mismatch:
                where = title(arguments, words)
                what = wrong_call(where, function, mismatch, arguments[own:], words)
                raise error(what) from None
            if not is_ours:
                raise
            where = title(arguments, words)
            raise error(f"{where}: fails with {failure(raised)}.") from raised

    return call


def checked_call(function: Callable[..., Any], name: str | None) -> Callable[..., Any]:
    """The callable, which says what it takes where its arguments do not fit its signature.

    A method without a name is named after the class of its object.
    """

    def title(arguments: tuple[Any, ...], _: Mapping[str, Any]) -> str:
        owner = [type(of).__name__ for of in arguments[:1]]
        return name or ".".join([*owner, function.__name__])

    return _guarded(function, title, InputError, is_ours=False)


def checked_class(cls: Class) -> Class:
    """The class, whose own public methods say what they take."""
    for word, method in _public_methods(cls):
        setattr(cls, word, checked_call(method, cls.__name__ if word == "__init__" else None))
    return cls


def _public_methods(cls: type[Any]) -> list[tuple[str, Callable[..., Any]]]:
    """The constructor of a class and its own public methods."""
    own = [(word, value) for word, value in vars(cls).items() if isfunction(value)]
    return [(word, value) for word, value in own if word == "__init__" or not word.startswith("_")]


def declaring(owner: str) -> Callable[[Function], Function]:
    """A decorator of the words of a declaration: all that fails in them is a `ModelError`.

    It names the word, and the element that it was to declare: ``model.force 'push'``.
    """

    def decorate(method: Function) -> Function:
        parameters = [*signature(method).parameters]
        own = int(parameters[:1] == ["self"])
        plain = method.__name__ in ("__init__", "__call__", owner)
        word = owner if plain else f"{owner}.{method.__name__}"

        def title(arguments: tuple[Any, ...], words: Mapping[str, Any]) -> str:
            name = words.get("name", (*arguments[own:], None)[0])
            of_whom = getattr(arguments[0], "name", None) if own and arguments else None
            text = word
            if own and "name" in parameters and name is not None:
                text += f" '{one_line(name)}'"
            if owner in ("body", "scene") and of_whom is not None:
                text += f" of '{of_whom}'"
            return text

        return _guarded(method, title, ModelError, is_ours=True)  # type: ignore[return-value]

    return decorate


def declaring_class(owner: str) -> Callable[[Class], Class]:
    """The same for the constructor of a class and all of its own public methods."""

    def decorate(cls: Class) -> Class:
        for word, method in _public_methods(cls):
            setattr(cls, word, declaring(owner)(method))
        return cls

    return decorate


def named_attributes(cls: Class) -> Class:
    """The class whose objects name themselves, and what they have, where an attribute is none."""

    def miss(of: Any, word: str) -> Any:
        if word.startswith("_") or any(word in vars(base) for base in type(of).__mro__):
            return object.__getattribute__(of, word)  # it fails with an error of its own
        known = [w for w in {*dir(type(of)), *vars(of)} if not w.startswith("_")]
        near = get_close_matches(word, sorted(known), n=3)
        hint = (
            f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(sorted(known))}."
        )
        name = vars(of).get("name")
        what = type(of).__name__ + ("" if name is None else f" '{one_line(name)}'")
        raise NoAttributeError(f"{what} has no {one_line(word)!r}; {hint}")

    cls.__getattr__ = miss
    return cls


class _Annotation:
    """An annotation that `help` shows as it is written, without the modules of its names."""

    def __init__(self, written: Any) -> None:
        self.written = written

    def __repr__(self) -> str:
        text = self.written if isinstance(self.written, str) else formatannotation(self.written)
        text = _QUALIFIED.sub("", _QUOTED.sub(_unquoted, text))
        return _ARRAY.sub(r"ndarray[\1]", text)


_QUOTED = re.compile(r"'([^']+)'")
_ARRAY = re.compile(r"ndarray\[tuple\[[^]]*\], dtype\[(\w+)\]\]")
_QUALIFIED = re.compile(r"\b(?:[a-z_]\w*\.)+(?=\w)")


def _unquoted(match: re.Match[str]) -> str:
    """A forward reference without its quotes; a word that an argument may be keeps them."""
    return match[1] if " | " in match[1] or match[1][:1].isupper() else match[0]


def readable(function: Function) -> Function:
    """The function with a signature that a person reads, `...` for a function by default."""
    about = signature(function)

    def short(annotation: Any) -> Any:
        return annotation if annotation is Parameter.empty else _Annotation(annotation)

    parameters = [
        p.replace(
            annotation=short(p.annotation),
            default=_Annotation("...") if isfunction(p.default) else p.default,
        )
        for p in about.parameters.values()
    ]
    vars(function)["__signature__"] = about.replace(
        parameters=parameters, return_annotation=short(about.return_annotation)
    )
    return function


def readable_class(cls: Class) -> Class:
    """The class, whose own constructor has a signature that a person reads."""
    for word in ("__new__", "__init__"):
        own = vars(cls).get(word)
        if own is not None:
            readable(getattr(own, "__func__", own))
    return cls


readable_class(LinkwrightError)
