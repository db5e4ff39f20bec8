"""Names of elements: the rules that they obey, and hints for unknown ones."""

import difflib
import keyword
import re
from collections.abc import Iterable

LONGEST = 32
IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")


def name_problem(kind: str, name: object) -> str | None:
    """Why `name` cannot be the name of a `kind`, or None if it can."""
    if not isinstance(name, str) or not IDENTIFIER.match(name) or keyword.iskeyword(name):
        reason = "is no identifier: use ASCII letters, digits and underscores, a letter first"
    elif "__" in name:
        reason = "has two underscores in a row, which separate model and scene in file names"
    elif len(name) > LONGEST and kind not in ("model", "scene"):
        reason = f"has {len(name)} characters; formulas stay readable with up to {LONGEST}"
    else:
        return None
    return f"{kind} name {name!r} {reason}."


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint that ends a message about an unknown name."""
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(repr(c) for c in close)}?"
    return f"there are: {', '.join(names)}." if names else "there are none."
