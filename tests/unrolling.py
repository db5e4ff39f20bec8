"""Machines whose kernels have the form that a test asks for, built apart from those of the library.

`load` takes what lies in `generated/`, whose modules have the form that suits their size.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import codegen
from codegen.emit.module import Unroll
from models.hard.suite.case import machine
from runtime import machine_loading


@contextmanager
def built_with(unroll: Unroll, folder: Path) -> Iterator[None]:
    """Within the block `load` builds machines into `folder`, with kernels in this form."""
    locate, build = machine_loading._locate, codegen.build

    def located(model: str, here: Path) -> tuple[Path, Path]:
        return locate(model, here)[0], folder

    def built(*given: Any, **settings: Any) -> Any:
        return build(*given, **settings | {"unroll": unroll})

    machine.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine_loading, "_locate", located)
        patch.setattr(codegen, "build", built)
        yield
    machine.cache_clear()
