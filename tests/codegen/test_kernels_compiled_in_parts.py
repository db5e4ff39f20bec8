"""The kernels of a long generated file compile in several processes, into one cache."""

from pathlib import Path

import pytest

from benchmarks.chain import chain
from codegen.driver import build
from codegen.errors import GeneratedFileError
from codegen.generated_files import machine_code
from codegen.generated_module_signature_and_import import kernel_lines


@pytest.fixture
def cold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that counts as long, whose kernels are not compiled."""
    monkeypatch.setattr(machine_code, "_LONG", 1)
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    return build(chain(2), out=tmp_path, compile=False).scenes[0].path


def test_each_kernel_is_compiled_by_one_process(
    cold: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts: list[list[str]] = []
    call = machine_code._call

    def recorded(function, path, *arguments):
        parts.extend(arguments)
        return call(function, path, *arguments)

    monkeypatch.setattr(machine_code, "_call", recorded)
    monkeypatch.setattr(machine_code, "import_generated", lambda path: None)
    machine_code.compile_modules([cold])
    kernels = kernel_lines(cold.read_text())
    assert len(parts) == 2
    assert sorted(parts[0] + parts[1]) == sorted(kernels)
    heavy = [sum(kernels[name] for name in part) for part in parts]
    assert max(heavy) < 0.7 * sum(heavy)
    kept = {file.name.split(".")[1].split("-")[0] for file in cold.parent.glob("__pycache__/*.nbi")}
    assert kept == {*kernels, "sin_cos"}


def test_what_does_not_compile_is_named(cold: Path) -> None:
    cold.write_text(cold.read_text().replace("def mass(q, p, values):", "def mass(q, p, others):"))
    with pytest.raises(GeneratedFileError, match="name 'values' is not defined"):
        machine_code.compile_modules([cold])
