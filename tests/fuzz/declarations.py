"""Declarations with arguments of the wrong kind, from a seed.

    python -m tests.fuzz declarations --count 100000 --seed 1

A case is a small machine, and a few calls of the methods of `Model` whose arguments are good, or
mean nothing where they stand. Its scenes are checked, derived, lowered and written, but not
compiled. Nonsense must be refused by an error of Linkwright's own that names the element, soon, and
nothing of what was given may be evaluated; what is accepted must come out as text that is sound.
"""

import ast
import re
import traceback
import warnings
from collections.abc import Callable
from inspect import signature
from random import Random
from typing import Any

from codegen import LinkwrightError, Model
from codegen.driver import translate
from codegen.emit.module import Origin, module_text
from codegen.errors import FAILURES
from codegen.generated_files.generated_file import Clock
from codegen.plain_values import shown
from codegen.reading.scene_selection import valid_scenes
from tests.fuzz.declared_arguments import Scenery
from tests.fuzz.declared_methods import BAD_NAMES, METHODS, NO_NAME
from tests.fuzz.declared_misuse import misuse
from tests.fuzz.declared_nonsense import MARK
from tests.fuzz.hostile_elements import hostile_body, hostile_element

LATE = re.compile(r"(model\.\w+|Model)( '\w*')?: fails with")  # the last guard of a declaration
# what cannot be read for another reason than its depth or the number of its digits
UNREAD = re.compile(r" cannot be read, (?!RecursionError|ValueError: Exceeds the limit)")
MISUSED = 0.3  # part of the cases that misuse something public in another way


def judge(random: Random) -> str | None:
    """What is wrong about the outcome of one case; None: nothing."""
    MARK.unlink(missing_ok=True)
    told: list[str] = []
    names: list[str] = []
    spoilt = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            scenery = Scenery(Model("m"))
            if random.random() < MISUSED:
                return _misuse_fault(scenery, random)
            for k in range(random.choice([1, 1, 2])):
                about, bad, name = _call(scenery, random, k)
                told.append(about[0])
                names.append(name)
                spoilt += bad
                about[1]()
            if random.random() < 0.15:
                spoilt += _user_element(scenery, random, told, names)
            text = _build(scenery.model)
            fault = f"accepted: {told}" if spoilt else _text_fault(text)
        except LinkwrightError as error:
            fault = _error_fault(error, names)
        except FAILURES as error:
            fault = f"{_place(error)}: {type(error).__name__}: {str(error)[:300]}"
    if MARK.exists():
        return f"evaluated: {told}"
    return fault and f"{fault}\n    {told}"


def _misuse_fault(scenery: Scenery, random: Random) -> str | None:
    """What is wrong about the answer to a misuse of something public."""
    misused = misuse(scenery, random)
    fault: str | None = None
    try:
        misused.call()
        fault = None if misused.may_be_right else "accepted"
    except LinkwrightError as error:
        fault = _error_fault(error, [misused.name])
    except FAILURES as error:
        fault = f"{_place(error)}: {type(error).__name__}: {str(error)[:300]}"
    if MARK.exists():
        fault = "evaluated"
    return fault and f"{fault}\n    {misused.words}"


def _call(
    scenery: Scenery, random: Random, k: int
) -> tuple[tuple[str, Callable[[], Any]], int, str]:
    """(the call in words, the call), how many arguments are nonsense, the element's name."""
    method = random.choice(list(METHODS))
    kinds = {
        word.rstrip("?"): kind
        for word, kind in METHODS[method].items()
        if not word.endswith("?") or random.random() < 0.4
    }
    defaults = signature(getattr(Model, method)).parameters
    values = {word: kind.good(scenery, random) for word, kind in kinds.items()}
    odd = random.sample(list(values), min(len(values), random.choice([0, 1, 1, 1, 1, 2])))
    for word in odd:
        values[word] = kinds[word].bad(scenery, random)
    odd = [w for w in odd if not _is_default(values[w], defaults[w].default)]
    name: Any = f"e{k}"
    spoilt = len(odd)
    if method not in NO_NAME:
        if random.random() < 0.05:
            name = random.choice(BAD_NAMES)
            # A scene may have the name of a body or a joint.
            spoilt += not (method == "scene" and type(name) is str and name in ("ground", "pin"))
        values = {"name": name, **values}
    shown = {w: v for w, v in values.items() if w in odd or w == "name"}
    words = f"{method}({', '.join(f'{w}={_short(v)}' for w, v in shown.items())}, ...)"
    written = name if isinstance(name, str) and name.isidentifier() else ""
    if method in NO_NAME:
        written = method
    return (words, lambda: getattr(scenery.model, method)(**values)), spoilt, written


def _is_default(value: Any, default: Any) -> bool:
    return value is default is None or (type(value) is str and value == default)


def _user_element(scenery: Scenery, random: Random, told: list[str], names: list[str]) -> int:
    """Add an element or a body of a modeller's own whose answers are nonsense."""
    make = hostile_body if random.random() < 0.2 else hostile_element
    names.append("mine")
    element, about = make(scenery.model, scenery.a, random)
    told.append(about)
    names[-1] *= " name" not in about[:11]
    scenery.model.add(element)
    return 1


def _build(model: Model) -> str:
    """The texts of all scenes."""
    texts = []
    for scene in valid_scenes(model, None):
        _, lowered, _ = translate(model, scene, Clock({}, lambda _: None, "fuzz"))
        origin = Origin("fuzz", (), "0", "build(m)")
        texts.append(module_text(lowered, origin))
    return "\n".join(texts)


SAFE = (ast.Import, ast.Assign, ast.FunctionDef, ast.Expr)


def _text_fault(text: str) -> str | None:
    """What a generated module says that none says."""
    for node in ast.parse(text).body:
        if not isinstance(node, SAFE):
            return f"the module contains {ast.unparse(node)[:200]}"
        if isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant):
            return f"the module runs {ast.unparse(node)[:200]}"
        if isinstance(node, ast.Import) and {a.name for a in node.names} - {
            "math",
            "numba",
            "numpy",
        }:
            return f"the module imports {ast.unparse(node)[:200]}"
    return None


def _error_fault(error: LinkwrightError, names: list[str]) -> str | None:
    """What is wrong about an error of ours: it names no element, or is no sentence."""
    text = str(error)
    if not error.problems or not text.strip():
        return f"{_place(error)}: an error without words"
    for problem in error.problems:
        if "\n" in problem or len(problem) > 3000 or not problem.isprintable():
            return f"{_place(error)}: no printable sentence: {problem[:300]!r}"
    if not any(name and name.lower() in text.lower() for name in names) and all(names):
        return f"{_place(error)}: names no element: {text[:300]}"
    if LATE.search(text) or UNREAD.search(text):
        return f"{_place(error)}: caught late: {text[:300]}"
    return None


def _place(error: BaseException) -> str:
    """Where an error was raised: the last line of ours, and the last of all."""
    while error.__cause__ is not None:
        error = error.__cause__
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/codegen/" in f.filename] or frames
    places = dict.fromkeys(
        f"{f.filename.rpartition('/')[2]}:{f.lineno}" for f in (ours[-1], frames[-1])
    )
    return " ".join(places)


def _short(value: Any) -> str:
    return ascii(shown(value))[1:121]
