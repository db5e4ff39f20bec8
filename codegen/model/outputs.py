"""What a scene reports beside the motion: the words of ``outputs=``."""

import re
from collections.abc import Iterable
from typing import Any

from codegen.declare.names import nearest
from codegen.declare.reading import Reader
from codegen.model.base import Declarations

GROUPS = ("reactions", "energy", "powers")
ONE = re.compile(r"(reaction|power)\((\w+)\)\Z")


class Outputs(Declarations):
    """Reads the outputs that a scene asks for."""

    def _read_outputs(self, read: Reader, where: str, wanted: Any) -> tuple[str, ...] | None:
        """The words in a fixed order, each once; None for all that there is."""
        if wanted is None or wanted == "all":
            return None
        if not isinstance(wanted, str | Iterable):
            read.problems.append(
                f"{where}: outputs={wanted!r} is no list; write outputs=['energy', 'power(gas)']."
            )
            return None
        found = []
        for word in (wanted,) if isinstance(wanted, str) else wanted:
            if problem := self._output_problem(word):
                read.problems.append(f"{where}: {problem}")
            else:
                found.append(str(word))
        order = (*GROUPS, *sorted(set(found) - set(GROUPS)))
        return tuple(word for word in order if word in found)

    def _output_problem(self, word: Any) -> str | None:
        if word in GROUPS:
            return None
        match = ONE.match(word) if isinstance(word, str) else None
        acting = [*self.joints, *self.drivers, *self.effects]
        if match is None:
            words = [*GROUPS, *(f"reaction({n})" for n in acting), *(f"power({n})" for n in acting)]
            return f"no output {word!r}; {nearest(str(word), words)}"
        if match[2] not in acting:
            return f"no output '{word}', as there is no '{match[2]}'; {nearest(match[2], acting)}"
        return None
