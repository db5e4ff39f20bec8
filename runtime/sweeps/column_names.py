"""Names of a study's columns, and of the folders in which the store keeps them."""

from collections.abc import Iterator, Sequence

from codegen.readers.values import shown

DONE, OUTCOME, MESSAGE, LAST, TIME, RUN = "block_mark", "outcome", "message", "t_last", "t", "run"
RESERVED = {DONE, OUTCOME, MESSAGE, LAST, TIME, RUN, "block"}
"""Names that no factor, quantity or series of a sweep may have."""
_LONGEST = 200  # safety: bytes of a folder's name; file systems permit 255


def stored_name(name: str) -> str:
    """The name of a column's folder: not all file systems permit the colon of a quantity."""
    word, colon, rest = name.partition(":")
    return f"{word}({rest})" if colon else name


def name_problems(names: Sequence[str]) -> Iterator[str]:
    """A sentence for each name that cannot be a column, or would share its folder with another."""
    folders = dict[str, str]()  # as file systems compare them that ignore case → name
    for name in dict.fromkeys(names):
        stored = stored_name(name)
        if not _permitted(name, stored):
            yield f"{shown(name)} cannot name a column of the study; choose another name."
            continue
        other = folders.setdefault(stored.casefold(), name)
        if names.count(name) > 1:
            yield (
                f"{name} would name several columns of the study; rename the quantity, "
                'quantities={"NAME": ...}, or leave one out.'
            )
        elif other != name:
            yield (
                f"{name} and {other} would be kept in one folder of the study, {stored}; rename "
                'one, quantities={"NAME": ...}.'
            )


def _permitted(name: str, stored: str) -> bool:
    special = not name.isprintable() or name != name.strip() or any(c in name for c in "/\\")
    length = len(stored.encode("utf-8", "replace"))
    reserved = name in RESERVED or stored.casefold() == "zarr.json"
    return bool(name) and not (
        special or reserved or name.startswith((".", "__")) or length > _LONGEST
    )
