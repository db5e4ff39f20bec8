"""Work and text of a build grow no faster than the machine: counts at a size and at its double."""

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import codegen
from benchmarks.chain import SCENE, chain
from codegen.declare.returned_values import memoize_methods
from codegen.derive.equations import derive
from codegen.driver import translate
from codegen.emit.kernel import Arguments
from codegen.emit.module import KernelTexts, kernel_texts
from codegen.generated_files.generated_file import Clock
from codegen.generated_files.provenance import fingerprint
from codegen.model import Model
from codegen.reading.scene_selection import valid_scenes
from models.hard.n_four_bar import n_four_bar

SOURCE = str(Path(codegen.__file__).parent)
FAMILIES: dict[str, tuple[Callable[[int], Model], str, int]] = {
    "chain": (chain, SCENE, 100),
    "n_four_bar": (n_four_bar, "fall", 50),
}
"""Machines by name: their declaration, a scene, and the fewer parts, all above the size from which
on sparse matrices stand in the build."""


class Calls:
    """Counts calls within a block, and steps of generators, module by module of the compiler."""

    def __init__(self) -> None:
        self.by_module: dict[str, int] = {}

    def __enter__(self) -> "Calls":
        self._before = sys.gettrace()
        sys.settrace(self._called)
        return self

    def __exit__(self, *failure: object) -> None:
        sys.settrace(self._before)

    def _called(self, frame: FrameType, event: str, argument: Any) -> None:
        file = frame.f_code.co_filename
        if file.startswith(SOURCE):
            self.by_module[file] = self.by_module.get(file, 0) + 1


@memoize_methods
def built(family: str, size: int) -> KernelTexts:
    """All stages from the declaration to the texts of kernels in loops."""
    declare, name, _ = FAMILIES[family]
    model = declare(size)
    (scene,) = valid_scenes(model, name)
    _, lowered, _ = translate(model, scene, Clock({}, lambda message: None, ""))
    fingerprint(derive(model, scene))
    return kernel_texts(lowered.program, Arguments.of(lowered.description), "never")


@cache
def builds(family: str) -> tuple[tuple[dict[str, int], KernelTexts], ...]:
    """Calls by module, and the texts, at the family's size and at its double."""
    size = FAMILIES[family][-1]
    built(family, size // 10)  # what is found once a process is found here
    found = []
    for parts in (size, 2 * size):
        with Calls() as calls:
            texts = built(family, parts)
        found.append((calls.by_module, texts))
    return tuple(found)


@pytest.mark.parametrize("family", FAMILIES)
def test_calls_of_a_build_grow_linearly(family: str) -> None:
    """In every module; a tenth is allowed for the ends of a machine and the depths of heaps."""
    (small, _), (large, _) = builds(family)
    assert sum(large.values()) <= 2.1 * sum(small.values())
    worse = [(name, few) for name, few in small.items() if large.get(name, 0) > 2.2 * few + 100]
    assert not worse


@pytest.mark.parametrize("family", FAMILIES)
def test_code_of_all_kernels_stays_and_their_tables_grow_linearly(family: str) -> None:
    """Lines of code, bytes of tables in the text, slots of the workspace."""
    (_, few), (_, many) = builds(family)
    code = [sum(len(text.lines()) for text in texts) for texts in (few, many)]
    assert code[1] <= 1.02 * code[0]
    for one, other in zip(few, many, strict=True):
        sizes = [sum(map(len, text.table_lines())) for text in (one, other)]
        assert sizes[1] <= 2.3 * sizes[0] + 500, one.kernel.name  # indices get a digit more
        assert other.workspace <= 2.05 * one.workspace, one.kernel.name


@pytest.mark.parametrize("family", FAMILIES)
def test_a_part_has_few_entries_in_tables_and_workspace(family: str) -> None:
    """What a call of `accelerations` reads for a part of the machine lies near in memory."""
    (text,) = [t for t in builds(family)[0][1] if t.kernel.name == "accelerations"]
    parts = FAMILIES[family][-1]
    slots = {"chain": 23, "n_four_bar": 48}[family]
    entries = 7  # of the checks, three a constraint, and of one loop
    tables = [table for table in text.tables if table.columns]  # type: ignore[union-attr]
    assert text.workspace <= slots * parts
    assert sum(len(table.columns) * len(table.columns[0]) for table in tables) <= entries * parts
