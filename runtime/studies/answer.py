"""What a study returns: sentences and tables for a terminal and a notebook, facts for programs."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from codegen.errors import UnknownNameError
from codegen.object_display import html_of, html_table
from codegen.readers.calls import checked_class
from codegen.readers.values import shown
from runtime.results.samples import plain

if TYPE_CHECKING:
    from rich.table import Table

Entry = TypeVar("Entry")


@checked_class
@dataclass(frozen=True)
class Answer:
    """What a study found, as data."""

    @property
    def title(self) -> str:
        """What was studied, in a line."""
        raise NotImplementedError

    def sentences(self, *, whole: bool = False) -> Iterator[str]:
        """What the study concludes, a line each; long reasons are cut short unless `whole`."""
        raise NotImplementedError

    def tables(self) -> "tuple[Table, ...]":
        """The tables for a terminal."""
        raise NotImplementedError

    def facts(self) -> dict[str, Any]:
        """All fields and the sentences, as JSON; a number that is not finite is null."""
        return {**plain(asdict(self)), "sentences": [*self.sentences(whole=True)]}

    def __repr__(self) -> str:
        """The title, and what the study concludes, a line each."""
        return "\n  ".join((self.title, *self.sentences()))

    def _repr_html_(self) -> str:
        """The same with the first table, for notebooks."""
        table = self.tables()[0]
        rows = zip(*(column.cells for column in table.columns), strict=True)
        head = [str(column.header) for column in table.columns]
        return html_of(f"{self!r}\n  {table.caption}", html_table(head, rows))


def titled(what: str, entries: Mapping[str, Entry], title: object) -> Entry:
    """The entry of a title; UnknownNameError, with those that there are, without one."""
    if not isinstance(title, str) or title not in entries:
        raise UnknownNameError(f"no {what} {shown(title)}; there are: {'; '.join(entries)}.")
    return entries[title]
