"""Kernels that are imported as generated ones, and a record of those that are translated."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from codegen.files.generated_modules import import_generated
from codegen.machine_code import kernels
from tests.codegen.machine_code.kernel_texts import HEAD


@pytest.fixture
def imported(tmp_path: Path) -> Callable[[str, str], ModuleType]:
    """Imports a text as a generated one."""

    def load(options: str, text: str) -> ModuleType:
        path = tmp_path / f"kernels_{len(list(tmp_path.iterdir()))}.py"
        path.write_text(f"{HEAD}{options}\n{text}")
        return import_generated(path)

    return load


@pytest.fixture
def translated(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the kernels that are translated from now on."""
    names: list[str] = []
    translate = kernels._translation

    def recorded(text: str, found: Any, *arguments: Any) -> bytes:
        code = translate(text, found, *arguments)
        names.extend(kernel.py_func.__name__ for kernel in found)
        return code

    monkeypatch.setattr(kernels, "_translation", recorded)
    return names
