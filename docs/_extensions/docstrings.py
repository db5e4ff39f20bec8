"""What the docstrings of this project need before napoleon reads them as numpydoc.

``.. methods:: CLASS`` on a page lists the public methods of a class from which `Model` derives, as
methods of `Model`: a new one is on the page without a line of its own. Those of classes that derive
from `Model` are methods of `SpaceModel`, and methods that refuse a word are left out.
"""

import re
from inspect import isfunction
from pydoc import locate
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

NAMES = re.compile(r"\w+(?:, \w+)*$")


def attributes_as_definitions(lines: list[str]) -> list[str]:
    """Turn the section of attributes into a list of definitions, where one entry may name several.

    Napoleon would take ``mass, inertia`` for an attribute `inertia` of the type `mass`.
    """
    done: list[str] = []
    inside = False
    for number, line in enumerate(lines):
        follows = lines[number + 1] if number + 1 < len(lines) else ""
        if follows.startswith("---"):
            inside = line == "Attributes"
            done.append(f".. rubric:: {line}" if inside else line)
        elif inside and line.startswith("---"):
            done.append("")
        elif inside and NAMES.match(line):
            done.append(", ".join(f"``{name}``" for name in line.split(", ")))
        else:
            done.append(line)
    return done


def read(_: "Sphinx", what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Prepare one docstring, in place."""
    if what in {"property", "attribute", "data"}:
        # An empty comment: else napoleon takes what stands before a colon for a type.
        lines[:0] = ["..", ""]
    lines[:] = [line.replace("|c'|", "``|c'|``") for line in attributes_as_definitions(lines)]


INTERNAL = ("unit_of",)  # methods that the compiler alone calls
METHODS = re.compile(r"^\.\. methods:: (\S+)$", re.MULTILINE)


def list_methods(_: "Sphinx", page: str, source: list[str]) -> None:
    """Write out the lists of methods on a page, in place."""

    def methods(match: re.Match[str]) -> str:
        cls: Any = locate(match[1])
        found = ((name, f) for name, f in vars(cls).items() if isfunction(f))
        public = [name for name, f in found if not f"_{f.__doc__}".startswith("_Refused")]
        in_space = "Model" in (base.__name__ for base in cls.__mro__)
        owner = "SpaceModel" if in_space else "Model"
        names = (name for name in public if not name.startswith("_") and name not in INTERNAL)
        return "\n\n".join(f".. automethod:: {owner}.{name}" for name in names)

    source[0] = METHODS.sub(methods, source[0])


def setup(app: "Sphinx") -> dict[str, bool]:
    """Read docstrings before napoleon does, and pages before their parser."""
    app.connect("source-read", list_methods)
    app.connect("autodoc-process-docstring", read, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
