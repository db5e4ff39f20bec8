"""Every way in which a user's input can be wrong, under one base class.

This module imports none of the others: the runtime raises the same errors without loading SymPy.
"""

import inspect
import sys
import warnings
from collections.abc import Iterable
from importlib import import_module
from types import ModuleType

FAILURES = (Exception, SystemExit, GeneratorExit)
"""What a user's own object or function may raise; KeyboardInterrupt is the wish to stop."""


class LinkwrightError(Exception):
    """Base of every error that Linkwright raises on purpose.

    Parameters
    ----------
    problems
        One sentence a problem: the fault, its place, the numbers that show it, the remedy.
    values
        Further values to carry in `args`, as any exception does.
    """

    def __init__(self, problems: str | Iterable[str] = (), *values: object) -> None:
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems), *values)

    def locate(self, place: str) -> None:
        """Let each sentence begin with the place where the error was raised."""
        self.problems = tuple(f"{place}: {problem}" for problem in self.problems)
        self.args = ("\n".join(self.problems), *self.args[1:])


class InputError(LinkwrightError):
    """The user's input is wrong; the command line returns the exit status 2."""


class UnknownNameError(InputError, KeyError):
    """A table has no row of this name; also a `KeyError`, like that of a mapping."""

    __str__ = Exception.__str__  # a KeyError would quote its message


class ModelError(InputError):
    """The declaration of a model contradicts itself or is incomplete."""


class ModelFileError(InputError):
    """A model file is missing, does not import, or declares no model."""


class SceneError(InputError):
    """A scene names something that the model does not have."""


class ParameterError(InputError):
    """A parameter does not exist, is not finite, or has the wrong sign."""


class GeneratedFileError(InputError):
    """A generated module is missing, stale, edited by hand, or cannot be written."""


class SupersededError(GeneratedFileError):
    """A generated file has changed since a machine was loaded or a sweep began."""


class AssemblyError(InputError):
    """No position of the bodies satisfies the joints and the start values."""


class RedundancyError(AssemblyError):
    """The constraints are not independent; the message names those to remove."""


class AnalysisError(InputError):
    """The analysis asked for does not fit the scene (drivers, degrees of freedom, masses)."""


class NoAttributeError(ModelError, AttributeError):
    """An attribute does not exist or cannot be changed; also an `AttributeError`."""


class TableWarning(UserWarning):
    """A curve through the points of a table deviates from the shape of the points."""

    def __init__(self, text: str = "") -> None:
        super().__init__(text)


def module_of_extra(module: str, extra: str, needs: str, otherwise: str = "") -> ModuleType:
    """A module that an extra of the package brings; InputError with the command that installs it.

    `needs` begins the sentence, ``"A sweep needs zarr"``, and `otherwise` ends it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"{needs}, which cannot be imported ({error}). Run pip install 'linkwright[{extra}]', "
            f"in the checkout pip install '.[{extra}]'{otherwise}."
        ) from error


def note(text: str, kind: type[Warning] = UserWarning) -> None:
    """Warn of what takes time and changes no result; no error, whatever the filters.

    It points at the line outside the library that has called it.
    """
    frame, level, ours = inspect.currentframe(), 1, ("codegen", "runtime", "linkwright")
    while frame and frame.f_globals.get("__name__", "").partition(".")[0] in ours:
        frame, level = frame.f_back, level + 1
    try:
        warnings.warn(text, kind, stacklevel=level)
    except kind:  # warnings are errors here
        sys.stderr.write(f"note: {text}\n")
