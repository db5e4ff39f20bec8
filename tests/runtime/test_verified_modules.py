"""A generated module that is verified is executed as its text says, whatever lies beside it."""

import hashlib
import importlib.util
import inspect
import marshal
import os
import struct
from pathlib import Path
from types import ModuleType

import pytest

from codegen.errors import GeneratedFileError
from codegen.files import generated_modules as generated
from codegen.generated_files.generated_file import is_current
from runtime.machine_loading import _fresh_module

TEXT = "VALUE = 1\n"


def test_byte_code_beside_a_module_is_not_run(tmp_path: Path) -> None:
    """Forged with the date that the loader gave byte code: 32 bits of the source's hash."""
    path = tmp_path / "module.py"
    path.write_text(TEXT)
    stamp = hashlib.sha256(TEXT.encode()).digest()[:4]
    code = marshal.dumps(compile("VALUE = 'somebody else'", str(path), "exec"))
    header = importlib.util.MAGIC_NUMBER + struct.pack("<I", 0) + stamp
    forged = Path(importlib.util.cache_from_source(str(path)))
    forged.parent.mkdir()
    forged.write_bytes(header + struct.pack("<I", len(TEXT)) + code)
    assert generated.import_generated(path, TEXT).VALUE == 1


def test_what_is_executed_is_the_text_that_was_verified(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "replaced.py"
    path.write_text(TEXT)
    execute = generated._execute

    def replaced(name: str, path: Path, text: str) -> ModuleType:
        path.write_text("VALUE = 'somebody else'\n")
        return execute(name, path, text)

    monkeypatch.setattr(generated, "_execute", replaced)
    assert generated.import_generated(path, TEXT).VALUE == 1


@pytest.mark.parametrize("line_end", ["\r\n", "\r"])
def test_other_line_ends_make_no_other_module(
    tmp_path: Path, mechanisms: ModuleType, monkeypatch: pytest.MonkeyPatch, line_end: str
) -> None:
    model = mechanisms.pendulum("swing").write(tmp_path)
    path = tmp_path / "generated" / "rod_pendulum__swing.py"
    text = path.read_text()
    path.write_bytes(text.replace("\n", line_end).encode())
    monkeypatch.setattr(generated, "_execute", lambda name, path, executed: executed)
    module, read = _fresh_module(model, path.parent, "swing")
    assert generated.import_generated(module, read) == text  # type: ignore[comparison-overlap]
    assert is_current(path, text)


def test_a_module_that_is_no_text_is_named(tmp_path: Path) -> None:
    path = tmp_path / "binary.py"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(GeneratedFileError, match=r"binary\.py is damaged .* Delete it"):
        generated.import_generated(path)


@pytest.mark.parametrize("name", ["slider_crank__compressor.py", "methods/dop853.py"])
def test_a_module_that_does_not_load_says_how_it_is_built_again(
    root: Path, tmp_path: Path, name: str
) -> None:
    text = (root / "generated" / name).read_text()
    command = "methods" if "methods" in name else "build models/slider_crank.py --scene compressor"
    path = tmp_path / "cut.py"
    path.write_text(text[: len(text) // 2] + "\n(")
    with pytest.raises(GeneratedFileError, match=rf"rebuild it: linkwright {command}$"):
        generated.import_generated(path)


def test_a_reloader_passes_generated_modules_by(tmp_path: Path) -> None:
    """IPython's rewrites what modules in use hold when their files change."""
    autoreload = pytest.importorskip("IPython.extensions.autoreload")
    path, reloader = tmp_path / "module.py", autoreload.ModuleReloader()
    texts, found = (f"def value():\n    return {k}\n" for k in (1, 2)), []
    first, second = texts
    for date, text in enumerate((first, second, first, second)):
        path.write_text(text)
        os.utime(path, (2e9 + date, 2e9 + date))
        found.append(generated.import_generated(path).value())
        reloader.check(check_all=True)
    assert found == [1, 2, 1, 2]
    value = generated.import_generated(path).value
    assert inspect.getsource(value) == second
