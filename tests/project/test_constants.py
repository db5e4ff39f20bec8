"""Every number that tunes the numerics has a kind and a reason, and stands on its page."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    """The script that makes the page."""
    spec = importlib.util.spec_from_file_location(
        "make_constants", ROOT / "docs" / "make_constants.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_every_constant_has_a_kind(tool: ModuleType) -> None:
    assert not tool.without_kind(tool.all_constants())


def test_page_is_up_to_date(tool: ModuleType) -> None:
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(tool.all_constants())


def test_kinds_are_read_where_they_stand(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    module = tmp_path / "module.py"
    module.write_text(
        "_ON_LINE = 5  # safety: on its line\n"
        "# accuracy: above\n# and further\nABOVE = 1e-9\n"
        'BELOW = 2.0**-3\n"""measured: below\nand further."""\n'
        "FIRST, SECOND = 0.5, 2.0  # measured: both\n"
        "NO_KIND = 0.5\n_NO_KIND = 3\nSLOT = 3\nTURN = 2.0 * math.pi\nA, B, C = 0, 1, 2\n"
        "\n# Layout: rows\n_ROW = 4\n_OTHER_ROW = 5\n"
    )
    assert [(c.name, c.value, c.kind, c.reason) for c in tool.read(module)] == [
        ("_ON_LINE", "5", "safety", "on its line"),
        ("ABOVE", "1e-9", "accuracy", "above and further"),
        ("BELOW", "2.0**-3", "measured", "below and further."),
        ("FIRST", "0.5", "measured", "both"),
        ("SECOND", "2.0", "measured", "both"),
        ("NO_KIND", "0.5", "", ""),
        ("_NO_KIND", "3", "", ""),
    ]
