"""The page of the command line is what the parser says today."""

import importlib.util
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def test_page_is_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location(
        "make_command_line", ROOT / "docs" / "make_command_line.py"
    )
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page()
