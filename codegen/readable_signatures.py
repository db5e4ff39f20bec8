"""Signatures as `help` and a notebook show them: short names, no modules, no addresses."""

import re
from collections.abc import Callable
from inspect import Parameter, formatannotation, isfunction, signature
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])
Class = TypeVar("Class", bound=type[Any])


class _Annotation:
    """An annotation that `help` shows as it is written, without the modules of its names."""

    def __init__(self, written: Any) -> None:
        self.written = written

    def __repr__(self) -> str:
        text = self.written if isinstance(self.written, str) else formatannotation(self.written)
        text = _QUALIFIED.sub("", _QUOTED.sub(_unquoted, text))
        return _ARRAY.sub(r"ndarray[\1]", text)

    def __eq__(self, other: object) -> bool:
        return bool(self.written == getattr(other, "written", other))

    def __hash__(self) -> int:
        return hash(self.written)


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

    parameters = (
        p.replace(
            annotation=short(p.annotation),
            default=_Annotation("...") if isfunction(p.default) else p.default,
        )
        for p in about.parameters.values()
    )
    answer = short(about.return_annotation)
    vars(function)["__signature__"] = about.replace(
        parameters=[*parameters], return_annotation=answer
    )
    return function


def readable_class(cls: Class) -> Class:
    """The class, whose own constructor has a signature that a person reads."""
    for word in ("__new__", "__init__"):
        own = vars(cls).get(word)
        if own is not None:
            readable(getattr(own, "__func__", own))
    return cls
