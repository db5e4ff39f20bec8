"""Names of elements: the rules that they obey, and hints for unknown ones."""

import difflib
import keyword
import re
from collections.abc import Iterable

from codegen.readers.values import WIDEST, shown

LONGEST = 32  # safety: characters of a name in formulas
_LONGEST_OF_FILES = 80  # safety: of a model's or a scene's; file systems allow 255 for all parts
IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")


def name_problem(kind: str, name: object) -> str | None:
    """Why `name` cannot be the name of a `kind`, or None if it can."""
    text = name if isinstance(name, str) else ""
    if keyword.iskeyword(text):
        reason = "is no identifier, but a word of Python's own; put an underscore behind it"
    elif not IDENTIFIER.match(text):
        reason = "is no identifier: use ASCII letters, digits and underscores, a letter first"
    elif "__" in text:
        reason = "has two underscores in a row, which separate model and scene in file names"
    elif len(text) > LONGEST and kind not in ("model", "scene"):
        reason = f"has {len(text)} characters; formulas stay readable with up to {LONGEST}"
    elif len(text) > _LONGEST_OF_FILES:
        reason = f"has {len(text)} characters; names of files may have up to {_LONGEST_OF_FILES}"
    else:
        return None
    return f"{kind} name {shown(name)} {reason}."


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint that ends a message about an unknown name."""
    names = sorted(known)
    close = difflib.get_close_matches(name[:WIDEST], names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(repr(c) for c in close)}?"
    return f"there are: {', '.join(names)}." if names else "there are none."


def nearest_quantity(name: str, known: Iterable[str]) -> str:
    """A hint about an unknown ``owner.letter``: the nearest letters of the owner, else all."""
    names = list(known)
    owner, _, letter = name[:WIDEST].rpartition(".")
    own = {k.rpartition(".")[2]: k for k in names if k.rpartition(".")[0] == owner}
    if not own:
        return nearest(name, names)
    close = difflib.get_close_matches(letter, own, n=3, cutoff=0.5) or own
    return f"did you mean {' or '.join(own[c] for c in close)}?"
