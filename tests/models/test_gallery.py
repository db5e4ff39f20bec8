"""The page of tables and figures."""

from pathlib import Path

import pytest
import typer
from matplotlib.figure import Figure

from models.studies.__main__ import main
from models.studies.chapter import STUDIES
from models.studies.gallery import Shown, markdown, title_of
from models.studies.rows import Row

ROWS = [
    Row("8.2.3", "|T|, N m", 1.23456789, 1.2345679, 1.23, "rounded"),
    Row("8.2.3", "x, m", 2.0, 2.0, None),
    Row("8.2.4", "holds", 1.0, 1.0, "yes", "rounded"),
]


def figure(*titles: str) -> Figure:
    made = Figure()
    for axes, title in zip(made.subplots(1, len(titles), squeeze=False)[0], titles, strict=True):
        axes.set_title(title)
    return made


def test_a_section_has_its_table_reasons_and_figures() -> None:
    shown = Shown(STUDIES[0], ROWS)
    drawn = list(shown.noting(iter([("8_2_4", figure("Torque", "Force\nat A"))])))
    assert [number for number, _ in drawn] == ["8_2_4"]
    text = markdown([shown])
    for line in (
        "## The compressor of section 8.2",
        "| 8.2.3 | \\|T\\|, N m | 1.23457 | 1.2345679 | 1.23 | (1) |",
        "| 8.2.3 | x, m | 2 | 2 |  |  |",
        "| 8.2.4 | holds | 1 | 1 | yes | (1) |",
        "(1) The book: rounded  ",
        "- `figure_8_2_4`: Torque; Force at A",
    ):
        assert line in text.splitlines()
    assert text.count("The book: rounded") == 1


def test_a_title_over_all_comes_first() -> None:
    made = figure("left", "right")
    made.suptitle("Both")
    assert title_of(made) == "Both; left; right"


def test_the_page_has_every_machine_and_every_scene(root: Path) -> None:
    text = (root / "docs" / "gallery" / "book.md").read_text(encoding="utf-8")
    for study in STUDIES:
        assert f"## {study.title[0].upper()}{study.title[1:]}\n" in text
        for scene in study.scenes:
            assert f"`{scene}`" in text
    assert "`figure_8_2_4`" in text


def test_a_gallery_without_tables_is_refused(tmp_path: Path) -> None:
    with pytest.raises(typer.BadParameter, match="--gallery writes the tables"):
        main(only_figures=True, gallery=tmp_path / "gallery.md")
