"""Which file of a motion is meant by the ending of its name, in capitals or not."""

from pathlib import Path

PAGES = (".html", ".htm")
MOVIES = (".mp4", ".gif", ".svg")


def is_page(file: Path) -> bool:
    """Whether a page is meant."""
    return file.suffix.lower() in PAGES


def is_movie(file: Path) -> bool:
    """Whether a movie is meant, or a figure of several positions."""
    return file.suffix.lower() in MOVIES
