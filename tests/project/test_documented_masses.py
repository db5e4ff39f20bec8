"""The examples of docs/how-to/masses-that-vary.md, run as they stand there."""

from pathlib import Path

from tests.documented import cells, run_cells


def test_masses_that_vary(root: Path, tmp_path: Path) -> None:
    """The page compares each of its machines with a closed form."""
    page = root / "docs" / "how-to" / "masses-that-vary.md"
    run_cells(page, tmp_path)
    assert sum(cell.count("assert ") for cell in cells(page)) == 6
