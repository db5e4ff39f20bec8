"""The table and the figures of section 8.2."""

from pathlib import Path

import pytest

from models.studies.compressor import table
from models.studies.compressor_figures import figures
from models.studies.drawing import draw

FIGURES = ("8_2_4", "8_2_5", "8_2_6", "8_2_7", "8_2_8")


def test_ours_is_the_exact_value_to_its_printed_digits() -> None:
    rows = table()
    assert len(rows) == 18
    for row in rows:
        digits = len(f"{row.exact:.9g}".replace("-", "").replace(".", "").lstrip("0"))
        tolerance = 0.6 * 10.0 ** (1 - digits) * max(1.0, abs(row.exact)) * 10
        assert abs(row.ours - row.exact) < max(tolerance, 1e-8 * abs(row.exact)), row


def test_a_row_that_differs_from_the_book_says_why() -> None:
    for row in table():
        if row.book is not None:
            last = len(f"{row.book:g}".partition(".")[2])
            if abs(row.exact - row.book) > 0.6 * 10.0**-last:
                assert row.reason, row


def test_every_figure_is_written_twice_and_alike_each_time(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path / "first")
    assert {p.name for p in written} == {
        f"figure_{number}.{ending}" for number in FIGURES for ending in ("png", "svg")
    }
    again = draw(figures(), tmp_path / "second")
    for one, other in zip(written, again, strict=True):
        assert one.stat().st_size > 10_000
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.parametrize("text", ["J₁ = 225 kg m² (stalls at 0.1149 s)", "t, s", "φ̇₁, rad/s"])
def test_the_flywheel_figure_says_what_it_shows(tmp_path: Path, text: str) -> None:
    draw(figures(), tmp_path)
    assert text in (tmp_path / "figure_8_2_5.svg").read_text()


def test_every_machine_says_what_it_is() -> None:
    from models.__main__ import machines

    found = machines()
    assert "slider_crank" in found
    assert all(line.endswith(".") for line in found.values())


def test_every_machine_has_a_page_of_its_motion(tmp_path: Path) -> None:
    from models.__main__ import machines
    from models.studies.animations import MACHINES, write_pages

    assert MACHINES.keys() == machines().keys()
    (page,) = write_pages(["slider_crank"], tmp_path)
    assert page.read_text().startswith("<!doctype html>")
