"""Public functions, methods and classes: called wrongly, they fail with errors of ours alone.

A wrong call names the callable, what it takes and what was given. `KeyboardInterrupt` is the user's
wish to stop and passes everywhere; all else that a user's own code raises is an answer to it.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from functools import wraps
from inspect import Parameter, isfunction, signature
from typing import Any, TypeVar

from codegen.errors import FAILURES, InputError, LinkwrightError, ModelError, NoAttributeError
from codegen.plain_values import class_name, genuine, one_line, plain_name, shown
from codegen.readable_signatures import readable

Class = TypeVar("Class", bound=type[Any])
_SHOWN = 40  # layout: characters of an argument in a message
readable(LinkwrightError.__init__)


def wrong_call(
    title: str, function: Callable[..., Any], mismatch: object, arguments: tuple[Any, ...],
    words: Mapping[str, Any],
) -> str:  # fmt: skip
    """What a callable takes, and what it was given instead."""
    taken = (p for p in signature(function).parameters.values() if p.name != "self")
    takes = ", ".join(map(_written, taken))
    given = [shown(a, _SHOWN) for a in arguments]
    given += [f"{one_line(k, _SHOWN)}={shown(v, _SHOWN)}" for k, v in words.items()]
    text = f"{title}: {one_line(mismatch)}; it takes ({takes}), and was given ({', '.join(given)})."
    known = signature(function).parameters
    near = [
        f"{one_line(word, _SHOWN)}: did you mean {found[0]}?"
        for word in words
        if word not in known and (found := get_close_matches(word, known, n=1))
    ]
    return " ".join([text, *near])


def _written(parameter: Parameter) -> str:
    stars = "*" * (
        2 * (parameter.kind is Parameter.VAR_KEYWORD) or parameter.kind is Parameter.VAR_POSITIONAL
    )
    default = parameter.default
    tail = "" if default is Parameter.empty or callable(default) else f"={shown(default, _SHOWN)}"
    return f"{stars}{parameter.name}{tail}"


def checked_call(
    function: Callable[..., Any], title: str | None, error: type[InputError] = InputError
) -> Callable[..., Any]:
    """The callable, which refuses arguments that do not fit its signature.

    A method without a title is named after the class of its object.
    """
    about = signature(function)

    @readable
    @wraps(function)
    def call(*arguments: Any, **words: Any) -> Any:
        try:
            about.bind(*arguments, **words)
        except TypeError as mismatch:
            given = arguments[1:] if next(iter(about.parameters), "") == "self" else arguments
            owner = () if title else (class_name(type(of)) for of in arguments[:1])
            name = title or ".".join([*owner, function.__name__])
            raise error(wrong_call(name, function, mismatch, given, words)) from None
        return function(*map(genuine, arguments), **{w: genuine(v) for w, v in words.items()})

    return call


def error_boundary(method: Callable[..., Any], owner: str) -> Callable[..., Any]:
    """A method or function of a declaration, whose failures are all `ModelError`s.

    It gets text for its `name`.

    What arguments do where they are read (iterate, compare, convert) is theirs, and may fail.
    """
    about = signature(method)
    title = (
        owner
        if method.__name__ in ("__init__", "__call__", owner)
        else f"{owner}.{method.__name__}"
    )
    own = int(next(iter(about.parameters), "") == "self")  # arguments before those of the caller
    named = own and "name" in about.parameters

    def label(arguments: tuple[Any, ...], words: Mapping[str, Any]) -> str:
        name = words.get("name", (*arguments[own:], None)[0]) if named else None
        called_on = arguments[0] if own and arguments else None
        of_whom = getattr(called_on, "__dict__", {}).get("name")
        text = title if name is None else f"{title} '{plain_name(name)}'"
        if owner in ("body", "scene") and of_whom is not None:
            text += f" of '{plain_name(of_whom)}'"
        return text

    @readable
    @wraps(method)
    def call(*arguments: Any, **words: Any) -> Any:
        if named and "name" in words:
            words["name"] = plain_name(words["name"])
        elif named and len(arguments) > own:
            arguments = (*arguments[:own], plain_name(arguments[own]), *arguments[own + 1 :])
        try:
            given = map(genuine, arguments[own:])
            return method(*arguments[:own], *given, **{w: genuine(v) for w, v in words.items()})
        except (LinkwrightError, KeyboardInterrupt):
            raise
        except BaseException as error:
            where = label(arguments, words)
            try:
                about.bind(*arguments, **words)
            except TypeError as mismatch:
                what = wrong_call(where, method, mismatch, arguments[own:], words)
                raise ModelError(what) from error
            raise ModelError(f"{where}: fails with {failure(error)}.") from error

    return call


def error_boundary_class(cls: Class, owner: str) -> Class:
    """The class with its own public methods bounded so."""
    for word, method in list(vars(cls).items()):
        if isfunction(method) and (word == "__init__" or not word.startswith("_")):
            setattr(cls, word, error_boundary(method, owner))
    return cls


def checked_class(cls: Class) -> Class:
    """The class with its own public methods called rightly, and with attributes that stay."""
    for word, method in list(vars(cls).items()):
        if isfunction(method) and (word == "__init__" or not word.startswith("_")):
            setattr(cls, word, checked_call(method, cls.__name__ if word == "__init__" else None))
    return cls


def immutable(
    cls: Class, but: Iterable[str] = (), why: str = "what is declared stays as it is"
) -> Class:
    """The class with attributes that are neither set nor deleted, but for some.

    Those that a user's subclass adds stay its own.
    """
    free = frozenset(but)

    def is_library(kind: type[Any]) -> bool:
        return kind.__module__.startswith(("codegen.", "runtime."))

    def is_ours(of: Any, word: str) -> bool:
        fields = getattr(cls, "__dataclass_fields__", {})
        known = word in fields or isinstance(getattr(cls, word, None), property)
        return type(of) is cls or known or is_library(type(of))

    def refuse(of: Any, word: str, *_: Any) -> None:
        if word in free or not is_ours(of, word):
            with suppress(AttributeError):
                getattr(object, "__setattr__" if _ else "__delattr__")(of, word, *_)
                return
        name = vars(of).get("name")
        kind = (type(of) if is_library(type(of)) else cls).__name__
        what = kind if name is None else f"{kind} '{plain_name(name)}'"
        verb = "set" if _ else "deleted"
        raise NoAttributeError(f"{what}: {one_line(word)!r} cannot be {verb}; {why}.")

    for special in ("__setattr__", "__delattr__"):
        setattr(cls, special, refuse)
    return cls


def named_attributes(cls: Class) -> Class:
    """The class whose objects name themselves, and what they have, where an attribute is none."""

    def miss(of: Any, word: str) -> Any:
        if word.startswith("_"):
            raise AttributeError(word)
        if any(word in vars(base) for base in type(of).__mro__):
            return object.__getattribute__(of, word)  # it exists, and fails with its own error
        known = {w for w in dir(type(of)) if not w.startswith("_")}
        known |= {w for w in vars(of) if not w.startswith("_")}
        near = get_close_matches(word, sorted(known), n=3)
        hint = (
            f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(sorted(known))}."
        )
        name = vars(of).get("name")
        what = class_name(type(of)) + ("" if name is None else f" '{plain_name(name)}'")
        raise NoAttributeError(f"{what} has no {one_line(word)!r}; {hint}")

    cls.__getattr__ = miss
    return cls


def declared_attributes(cls: Class) -> Class:
    """The class of which only attributes are set that it, or a base of it, annotates."""
    annotated = {word for of in cls.__mro__ for word in vars(of).get("__annotations__", ())}
    return immutable(cls, annotated, "it has no such attribute, and nothing would read it")


class DeclaredTable(dict[str, Any]):
    """What is declared, by name: read by everybody, written by the declaration alone."""

    owner = "a table of a model"

    def __init__(self, owner: str, entries: Mapping[str, Any] | None = None) -> None:
        super().__init__(entries or {})
        self.owner = owner

    def declare(self, name: str, entry: Any) -> None:
        """Add an entry, or replace the one of that name."""
        super().__setitem__(name, entry)

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.owner, dict(self)))

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise NoAttributeError(
            f"{self.owner} is a view of what is declared, and is not written to; declare with the "
            "methods of the model."
        )

    __setitem__ = __delitem__ = __ior__ = update = setdefault = _refuse
    pop = popitem = clear = _refuse
    fromkeys: Any = classmethod(_refuse)  # type: ignore[arg-type]


def failure(error: BaseException) -> str:
    """An exception of somebody else's in a message."""
    if isinstance(error, RecursionError):
        return "RecursionError: functions of functions are too deep for Python's stack"
    from codegen.sympy_remedies import sympy_remedy  # an exception is rare, an import is not

    said = f"{type(error).__name__}: {one_line(error)}".removesuffix(": ").rstrip(".")
    remedy = sympy_remedy(error)
    return f"{said} ({remedy})" if remedy else said


class UserCallback:
    """A user's function that is called until it raises; its exception waits for a block's end."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.error: Exception | None = None

    def __call__(self, *arguments: Any) -> None:
        """Call it, unless it has raised."""
        if self.error is None:
            try:
                self.function(*arguments)
            except Exception as error:
                self.error = error

    def __enter__(self) -> "UserCallback":
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None and self.error is not None:
            raise self.error


@contextmanager
def note_user_error(what: str) -> Iterator[None]:
    """A block that calls a user's function: its exception passes on, and says whose it is."""
    try:
        yield
    except BaseException as error:
        error.add_note(f"{what} raised this: it is the caller's own.")
        raise


def unreadable(error: BaseException) -> str:
    """What to do about an expression at which SymPy fails."""
    if isinstance(error, RecursionError):
        return (
            "an expression is too deep for Python's stack: functions of functions, some hundred "
            "one in another; write it in fewer, or as a table of its values (model.table)."
        )
    if isinstance(error, ValueError) and "integer string conversion" in str(error):
        return "an expression contains a number of thousands of digits; give finite floats."
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
    except FAILURES as error:  # of an expression too deep, of SymPy
        raise ModelError(f"{where}: {unreadable(error)}") from error
