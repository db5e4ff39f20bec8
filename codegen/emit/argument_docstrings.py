"""The arguments of a module's kernels: shapes and units, for docstrings."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from textwrap import wrap

from codegen.emit.line_wrapping import quantity
from codegen.lower.module_tables import Description
from codegen.lower.program import Kernel, Program

PER_COORDINATE = ("q", "v", "a", "w", "dq", "dv", "dq_in", "dv_in", "da", "Q", "g")
RATES = {"v": "/s", "a": "/s^2", "da": "/s^2", "dv": "/s", "dv_in": "/s", "all_v": "/s"}
"""Arguments that are rates of coordinates: what follows the coordinate's unit."""
AS_COORDINATES = ("q", "dq", "dq_in", "all_q", *RATES)


@dataclass(frozen=True)
class Arguments:
    """Shapes and units of arguments."""

    declared: int  # declared parameters, behind which the constants stand in `p`
    # argument → length; those of outputs follow from a kernel itself where they are missing
    sizes: Mapping[str, int] = field(default_factory=dict)
    units: tuple[str, ...] = ()  # of the coordinates

    @classmethod
    def of(
        cls, description: Description, kept: tuple[int, ...] | None = None, more: int = 0
    ) -> "Arguments":
        """Those of a scene, or of its equations in the coordinates `kept`.

        In ``p`` `more` entries that are no constants stand behind the parameters.
        """
        n = len(description.coordinates if kept is None else kept)
        sizes = dict.fromkeys(PER_COORDINATE, n)
        sizes |= {"lam": len(description.constraints), "modes": len(description.switches)}
        units = tuple(dict.fromkeys(unit for *_, unit in description.coordinates))
        return cls(len(description.parameters) + more, sizes, units)

    def slots(self, program: Program) -> dict[int, int]:
        """Constant → its slot in ``p``."""
        return {number: self.declared + k for k, number in enumerate(program.constants)}

    def lines(self, program: Program, kernel: Kernel) -> Iterator[str]:
        """What a kernel reads, writes and returns; nothing where no sizes are known."""
        if not self.sizes:
            return
        if kernel.name == "constants":
            behind = quantity(len(program.constants), "constant")
            yield f"Reads {quantity(self.declared, 'parameter')} in p, writes {behind} behind."
            return
        counts: dict[str, int] = {}
        for out in kernel.outputs:
            counts[out.array] = max(counts.get(out.array, 0), out.slot + 1)
        sizes = {**counts, **self.sizes, "p": self.declared + len(program.constants)}
        if kernel.name != "potential_gradient":
            sizes["g"] = counts.get("g", 0)
        texts = {name: self._text(name, sizes) for name in kernel.arguments}
        read = [text for name, text in texts.items() if name not in counts or name == "p"]
        written = [text for name, text in texts.items() if name in counts]
        sentence = f"Reads {', '.join(read)}."
        sentence += f" Writes {', '.join(written)}." if written else ""
        if kernel.watched:
            sentence += " Returns 0, or 1 + the row of CONSTRAINTS whose pivot is weak."
        yield from wrap(sentence, 94, break_long_words=False, break_on_hyphens=False)

    def _text(self, name: str, sizes: Mapping[str, int]) -> str:
        if name == "t":
            return "t in s"
        text = f"{name} ({sizes.get(name, 0)},)"
        if name in AS_COORDINATES and self.units:
            text += f" in {' or '.join(unit + RATES.get(name, '') for unit in self.units)}"
        return text
