"""Errors of wrong calls: a public function, method or class names the arguments that it takes.

A wrong call names the callable, what it takes and what was given; an attribute that an object does
not have is answered with those that are spelt alike. Signatures are shown as a person reads them.
Exceptions that are not ours, of SymPy or of a user's function, are told with what to do.
"""

import re
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from functools import wraps
from inspect import Parameter, formatannotation, isfunction, signature
from typing import Any, TypeVar

from codegen.errors import InputError, LinkwrightError, ModelError, NoAttributeError
from codegen.readers.values import one_line, shown

Class = TypeVar("Class", bound=type[Any])
Function = TypeVar("Function", bound=Callable[..., Any])
# a word → the one, or none, that a callable takes which does not take it
_LIKE = {"start": "guess", "from_": ""}
_SHOWN = 40  # layout: characters of an argument in a message


def wrong_call(
    title: str, function: Callable[..., Any], mismatch: object, arguments: tuple[Any, ...],
    words: Mapping[str, Any],
) -> str:  # fmt: skip
    """What a callable takes, and what it was given instead."""
    known = signature(function).parameters
    written = {p.name: _written(p) for p in known.values() if p.name != "self"}
    by_name = [p.name for p in known.values() if p.kind is Parameter.KEYWORD_ONLY]
    if by_name and "too many" in one_line(mismatch):
        written[by_name[0]] = f"*, {written[by_name[0]]}"
    takes = ", ".join(written.values())
    given = [shown(a, _SHOWN) for a in arguments]
    given += [f"{one_line(k, _SHOWN)}={shown(v, _SHOWN)}" for k, v in words.items()]
    text = f"{title}: {one_line(mismatch)}; it takes ({takes}), and was given ({', '.join(given)})."
    near = [
        f"{one_line(word, _SHOWN)}: did you mean {found[0]}?"
        for word in words
        if word not in known and (found := get_close_matches(_LIKE.get(word, word), known, n=1))
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
    """The callable, which says what it takes and, where it `is_ours`, what else fails in it."""
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


def _with_methods(cls: Class, decorate: Callable[[Any], Any]) -> Class:
    """The class, with its constructor and its own public methods decorated."""
    for word, method in list(vars(cls).items()):
        if isfunction(method) and (word == "__init__" or not word.startswith("_")):
            setattr(cls, word, decorate(method))
    return cls


def checked_class(cls: Class) -> Class:
    """The class, whose own public methods say what they take."""
    name = {"__init__": cls.__name__}
    return _with_methods(cls, lambda method: checked_call(method, name.get(method.__name__)))


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
    return lambda cls: _with_methods(cls, declaring(owner))


def named_attributes(cls: Class) -> Class:
    """The class whose objects name themselves, and what they have, where an attribute is none.

    A class may have ``_unlisted``, words that are never offered, and then methods alone are listed;
    and ``_synonyms``, word → words of others for it.
    """

    def miss(of: Any, word: str) -> Any:
        if word.startswith("_") or any(word in vars(base) for base in type(of).__mro__):
            return object.__getattribute__(of, word)  # it fails with an error of its own
        own, unlisted = type(of), getattr(type(of), "_unlisted", ())
        words = {*dir(own), *vars(of)}.difference(unlisted)
        known, synonyms = sorted(w for w in words if w[0] != "_"), getattr(own, "_synonyms", {})
        plain = word.lower().removeprefix("add_").removesuffix("_joint")
        near = [w for w, others in synonyms.items() if w in known and plain in others.split()]
        near = near or get_close_matches(word, known, n=3)
        listed = [w for w in known if not unlisted or callable(getattr(own, w, None))]
        hint = f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(listed)}."
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


_CALL = re.compile(r"\b(math|np|numpy)\.(\w+)\(")
# NumPy names its function, or asks an expression for a method of that name
_NAMED = re.compile(r"(?:has no callable |ufunc '|object has no attribute ')(\w+)")
_SAME = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh",
    "atanh", "exp", "log", "sqrt", "sign", "floor", "erf", "gamma", "factorial",
)  # fmt: skip
_IN_SYMPY = {
    **{name: f"sympy.{name}" for name in _SAME},
    **{f"arc{name[1:]}": f"sympy.{name}" for name in _SAME if name.startswith("a")},
    **dict.fromkeys(("fabs", "abs", "absolute"), "sympy.Abs"),
    "maximum": "sympy.Max",
    "minimum": "sympy.Min",
    "where": "sympy.Piecewise",
    "heaviside": "sympy.Heaviside",
    **dict.fromkeys(("fmod", "mod", "remainder"), "sympy.Mod"),
    "ceil": "sympy.ceiling",
    **dict.fromkeys(("pow", "power"), "x**y"),
    "square": "x**2",
    "hypot": "sympy.sqrt(x**2 + y**2)",
    "log10": "sympy.log(x, 10)",
    "log2": "sympy.log(x, 2)",
    **dict.fromkeys(("radians", "deg2rad"), "sympy.rad"),
    **dict.fromkeys(("degrees", "rad2deg"), "sympy.deg"),
    "clip": "sympy.Max and sympy.Min",
}
"""Functions of math and NumPy → what an expression is written with."""


def sympy_remedy(error: BaseException) -> str:
    """A sentence for an exception that an expression of coordinates caused; empty for others.

    SymPy says that it cannot convert an expression to a number, NumPy that an object has no method,
    and neither says what to write.
    """
    text = one_line(error) if type(error) in {AttributeError, TypeError} else ""
    if "truth value of Relational" in text:
        return (
            "Python's if, and, or, max and min need numbers: use sympy.Piecewise, And, Or, Max and "
            "Min of coordinates and parameters, or when= of a force"
        )
    named = _NAMED.search(text)
    if "NoneType" in text or not (named or "Cannot convert" in text):
        return ""
    lines = [frame.line or "" for frame in traceback.extract_tb(error.__traceback__)]
    calls = [call for line in lines for call in _CALL.findall(line)]
    if named:
        calls = [call for call in calls if call[1] == named[1]]
        if not calls and type(error) is AttributeError:
            return ""
    package, name = calls[-1] if calls else ("numpy", named[1] if named else "")
    if name not in _IN_SYMPY:
        return "math, NumPy and float() need numbers: use functions of sympy, such as sympy.sin"
    return f"math and NumPy need numbers: use {_IN_SYMPY[name]} in place of {package}.{name}"


def failure(error: BaseException) -> str:
    """An exception of somebody else's in a message."""
    if isinstance(error, RecursionError):
        return "RecursionError: functions of functions are too deep for Python's stack"
    said = f"{type(error).__name__}: {one_line(error)}".removesuffix(": ").rstrip(".")
    remedy = sympy_remedy(error)
    return f"{said} ({remedy})" if remedy else said


def unreadable(error: BaseException) -> str:
    """What to do about an expression at which SymPy fails."""
    if isinstance(error, RecursionError):
        return (
            "an expression is too deep for Python's stack: functions of functions, some hundred "
            "one in another; write it in fewer, or as a table of its values (model.table)."
        )
    return (
        f"an expression is beyond SymPy, which fails with {failure(error)}; write it in another "
        "form, of powers, sines and the other functions that are compiled."
    )


@contextmanager
def errors_at(where: str) -> Iterator[None]:
    """Errors in the block that are not ours say where they come from."""
    try:
        yield
    except LinkwrightError:
        raise
    except Exception as error:  # of an expression too deep, of SymPy
        raise ModelError(f"{where}: {unreadable(error)}") from error


@contextmanager
def note_user_error(what: str) -> Iterator[None]:
    """A block that calls a user's function: its exception passes on, and says whose it is."""
    try:
        yield
    except BaseException as error:
        error.add_note(f"{what} raised this: it is the caller's own.")
        raise
