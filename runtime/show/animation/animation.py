"""An animation of one run or several: shown in a notebook, saved as a page."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen import __version__
from codegen.whole_files import whole_file
from runtime.show.animation.happenings import happenings
from runtime.show.animation.instants import animated
from runtime.show.animation.page_text import framed, page_text
from runtime.show.animation.payload import Arrays, block
from runtime.show.animation.quantities import curves
from runtime.show.animation.scenery import scenery
from runtime.show.pictures import Pictures, pictures

if TYPE_CHECKING:
    from runtime.results.result import Result

_HEIGHT = 720  # layout: of the frame in a notebook, px


def run_data(
    result: "Result", pictures: Pictures, label: str, arrays: Arrays
) -> dict[str, Any]:
    """A run as the page has it."""
    series, groups = curves(result, arrays)
    return {
        "label": label,
        "title": result.description.title,
        "analysis": result.analysis,
        "outcome": result.outcome.name,
        "message": result.message,
        "failed": result.failed,
        "t": arrays.add_exactly(result.t),
        "series": series,
        "groups": groups,
        "events": happenings(result),
        **scenery(pictures, arrays),
    }
