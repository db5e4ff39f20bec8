"""The figures and pages of a result."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from codegen.errors import InputError
from codegen.presentation import VIEWS, in_pyplot
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class
from runtime.results.series_lookup import TimeSeries

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.result import Result
    from runtime.show.animation.animation import Animation


@checked_class
class ResultFigures(TimeSeries):
    """Plots, pictures and motion of a result; see `Result`."""

    @in_pyplot()
    def plot(self, *names: str, unit: str | Sequence[str] = ()) -> "Figure":
        """Draw series over time, one panel for each unit, with the values that `at` returns.

        Parameters
        ----------
        names
            As in `series`; without any, the coordinates that are angles, in space the other
            coordinates than Euler parameters, and the angular velocities.
        unit
            A unit or several, ``("mm", "rpm")``: each series that fits one is drawn in it.

        Returns
        -------
        Figure
            Of Matplotlib's pyplot: ``plt.show()`` shows it in a script, ``plt.close(figure)`` drops
            it, ``figure.savefig("run.png")`` saves it; a notebook shows it below the cell.

        Raises
        ------
        InputError
            If there is no such series, a unit fits none, or matplotlib is not installed.
        """
        from runtime.show.pictures import plot

        return plot(cast("Result", self), names, unit)

    @in_pyplot()
    @readers.reads(
        t=readers.optional(readers.number("a finite number, an instant in s", unit="s")),
        **dict.fromkeys(("dimensions", "forces", "frames", "names"), readers.flag),
        view=readers.word(*VIEWS),
    )
    def draw(
        self, t: float | None = None, *, dimensions: bool = False, forces: bool = False,
        frames: bool = False, names: bool = True, view: str = "usual",
    ) -> "Figure":  # fmt: skip
        """Draw the machine at an instant of the motion.

        Parameters
        ----------
        t
            Instant in s, as `at` takes it; unless given, the first sample.
        dimensions, forces, frames, names, view
            As for `Model.draw`; forces are also those of joints and drivers, but no weights.

        Raises
        ------
        InputError
            If `t` is not within the result, or Matplotlib is not installed.
        """
        from runtime.show.pictures import draw_result

        return draw_result(
            cast("Result", self), t, dimensions=dimensions, forces=forces, frames=frames,
            names=names, view=view,
        )  # fmt: skip

    @readers.reads(
        file=readers.optional(readers.path),
        frames_per_second=readers.optional(readers.count(1, 240)),
        width=readers.optional(readers.count(200, 4000)),
        speed=readers.optional(readers.number("a positive number", above=0.0)),
        span=readers.optional(readers.several(
            readers.number("a finite number"), "the first and last instant, such as (0.0, 1.5)"
        )),
        progress=readers.flag,
    )  # fmt: skip
    def animate(
        self, file: str | os.PathLike[str] | None = None, *, frames_per_second: int | None = None,
        width: int | None = None, speed: float | None = None,
        span: tuple[float, float] | None = None, progress: bool = True,
    ) -> "Animation | Path":  # fmt: skip
        """Show the machine in motion, as a page with forces and curves, or as a movie.

        Parameters
        ----------
        file
            An .html file to write the page into. Or, in place of a page, an .mp4 or .gif movie, or
            an .svg with some positions drawn over each other.
        frames_per_second, width, speed, span, progress
            As for `runtime.show.movie.save_movie`, for movies only; `span` also for an .svg.

        Returns
        -------
        Animation or Path
            The page, which a notebook shows and `Animation.save` writes; or the path of the movie.
            `runtime.animate` shows several runs beside each other.

        Raises
        ------
        InputError
            If there is no motion, the file cannot be written, or bokeh, Matplotlib or ffmpeg is
            not installed.
        """
        from codegen.presentation import is_page
        from runtime.show.movie import save_movie

        if file is not None and Path(file).suffix and not is_page(Path(file)):
            return save_movie(
                cast("Result", self), Path(file), frames_per_second=frames_per_second,
                width=width, speed=speed, span=span, progress=progress,
            )  # fmt: skip
        if any(value is not None for value in (frames_per_second, width, speed, span)):
            raise InputError(
                "animate: frames_per_second=, width=, speed= and span= are those of a movie; give "
                "file= with the ending .mp4, .gif or .svg as well."
            )
        from runtime.show.animation.animation import animate

        return animate([cast("Result", self)], file=file)
