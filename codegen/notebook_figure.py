"""A figure that a notebook shows as a picture, whichever backend of matplotlib is in force."""

import io

from matplotlib.figure import Figure

_RESOLUTION = 110  # layout: dots per inch, 700 to 1000 of them across a page


class NotebookFigure(Figure):
    """A figure of matplotlib with a picture for the cell of a notebook that answers it."""

    def _repr_png_(self) -> bytes:
        """The figure as .png."""
        stream = io.BytesIO()
        self.savefig(stream, format="png", dpi=_RESOLUTION)
        return stream.getvalue()
