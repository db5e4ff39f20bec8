"""A line of the table that sets our numbers beside the exact ones and the book's."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One quantity.

    Attributes
    ----------
    section, quantity
        Where the book has it, and what it is, with its unit.
    ours
        What this program computed just now.
    exact
        From an independent solution in extended precision, or a closed form.
    book
        As printed, a number or a word; None where the book says nothing.
    reason
        Why the book's number differs from the exact one, if it does.
    """

    section: str
    quantity: str
    ours: float
    exact: float
    book: float | str | None = None
    reason: str = ""
