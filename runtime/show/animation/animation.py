"""An animation of one run or several: shown in a notebook, saved as a page."""

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.drawing.picture import MovingPicture
from codegen.errors import InputError, LinkwrightError
from codegen.files.whole_files import whole_file
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class
from runtime.show.animation.compressed_arrays import block, in_two
from runtime.show.animation.curves import curves, require_bokeh
from runtime.show.animation.instants import animated
from runtime.show.animation.page_data import NO_MACHINE, event_marks, machine_data, unit_for
from runtime.show.animation.page_text import framed, page_text
from runtime.show.file_endings import is_movie, is_page
from runtime.show.moving_picture import moving_picture
from runtime.show.still import exerted

if TYPE_CHECKING:
    from runtime.results.result import Result

_HEIGHT = 720  # layout: of the frame in a notebook, px
MAX_RUNS = 6  # layout: runs beside each other


@checked_class
class Animation:
    """A machine in motion with its curves, as a page that needs nothing else.

    In a notebook it shows itself, also after the export to HTML.

    Attributes
    ----------
    title
        Model and scene.
    labels
        What tells the runs apart, one text a run.
    html
        The page as text.
    """

    title: str
    labels: tuple[str, ...]

    def __init__(
        self, results: "Sequence[Result]", labels: Sequence[str] = (), below: str = ""
    ) -> None:
        self._results, self._below = tuple(results), below
        self.title = " and ".join(dict.fromkeys(r.description.title for r in results))
        self.labels = tuple(labels) or differences(self._results)

    @cached_property
    def html(self) -> str:
        """The page as text; it is made once."""
        shown = [animated(result) for result in self._results]
        machines = [_moving_picture(run) for run in shown]
        sizes: dict[str, float] = {}  # of the largest run of a machine
        for run, machine in zip(shown, machines, strict=True):
            title = run.description.title
            size = 1.0 if isinstance(machine, str) else machine.picture.size
            sizes[title] = max(sizes.get(title, 0.0), size)
        runs = []
        for number, (run, machine) in enumerate(zip(shown, machines, strict=True)):
            series, groups = curves(run)
            title, marks = run.description.title, event_marks(self._results[number])
            if isinstance(machine, str):
                data = {**NO_MACHINE, "missing": machine, "events": marks}
            else:
                data = machine_data(machine, unit_for(sizes[title]), exerted(run), marks)
            runs.append({
                "label": self.labels[number], "title": title, "t": in_two(run.t),
                "series": series, "groups": groups, **data,
            })  # fmt: skip
        has_curves = any(len(result.t) > 1 for result in self._results)
        return page_text(
            self.title, block({"runs": runs}), self._below,
            has_curves=has_curves, runs=len(runs),
        )  # fmt: skip

    @readers.reads(path=readers.path)
    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page to a file, whole or not at all.

        Parameters
        ----------
        path
            Ending in .html or .htm; a file of that name is replaced.

        Raises
        ------
        InputError
            If the ending is another one, the folder does not exist or cannot be written.
        """
        place = Path(path)
        if not is_page(place):
            raise InputError(
                f"{place}: an animation is saved as .html, not as "
                f"{place.suffix or 'a file without ending'!r}. Change the ending."
            )
        html = self.html
        with whole_file(place) as temporary:
            temporary.write_text(html, encoding="utf-8")
        return place

    def __repr__(self) -> str:
        """Title and runs."""
        runs = f": {', '.join(self.labels)}" if len(self.labels) > 1 else ""
        return f"Animation of {self.title}{runs}; .save('FILE.html') writes it as a page"

    def _repr_html_(self) -> str:
        """The page in a frame, for notebooks."""
        return framed(self.html, f"Animation of {self.title}", _HEIGHT)


_RESULT = readers.instance("runtime.results", "Result", "a result of a machine")


@readers.reads(
    results=readers.several(_RESULT, "a list of results, such as [first, second]"),
    file=readers.optional(readers.path),
    labels=readers.texts('["light", "heavy"]'),
)
def animate(
    results: "Sequence[Result]",
    *,
    file: str | os.PathLike[str] | None = None,
    labels: Sequence[str] = (),
) -> Animation:
    """Show runs in motion beside each other, with one clock and their curves in one picture.

    Parameters
    ----------
    results
        Of simulations, kinematics or inverse dynamics, up to six; of one machine or several.
    file
        An .html file to write as well.
    labels
        A text for each run; unless given, the parameters in which they differ.

    Returns
    -------
    Animation
        Which a notebook shows, and `Animation.save` writes.

    Raises
    ------
    InputError
        If there is no run or more than six, one has no instants, the number of labels is another
        one, or bokeh is not installed.
    """
    runs = tuple(results)
    problems = []
    if not 0 < len(runs) <= MAX_RUNS:
        problems.append(f"animate: {len(runs)} runs; it shows 1 to {MAX_RUNS}.")
    if labels and len(labels) != len(runs):
        problems.append(f"animate: {len(labels)} labels for {len(runs)} runs; give one each.")
    if file is not None and is_movie(Path(file)):
        problems.append(
            f"animate: {Path(file).name} is a movie, which shows one run; write it by "
            f"RESULT.animate(file={Path(file).name!r}). Runs beside each other are an .html page."
        )
    problems += [
        f"animate: run {k + 1}, {run.description.title}, has no instants ({run.message})"
        for k, run in enumerate(runs)
        if not len(run.t)
    ]
    if problems:
        raise InputError(problems)
    if any(len(run.t) > 1 for run in runs):
        require_bokeh()
    shown = Animation(runs, labels)
    if file is not None:
        shown.save(file)
    return shown


def differences(results: "Sequence[Result]") -> tuple[str, ...]:
    """What tells runs apart: scenes, analyses and parameters in which they differ, or a number."""
    if len(results) == 1:
        return ("",)
    first = results[0]
    names = [
        name
        for name in first.parameters
        if any(r.parameters.get(name) != first.parameters[name] for r in results)
    ]
    titles = len({r.description.title for r in results}) > 1
    analyses = len({r.analysis for r in results}) > 1
    labels = [
        ", ".join(
            [r.description.title] * titles
            + [r.analysis] * analyses
            + [f"{name} = {r.parameters[name]:.6g}" for name in names if name in r.parameters]
        )
        for r in results
    ]
    if len(set(labels)) < len(results):
        labels = [f"run {k + 1}" for k in range(len(results))]
    return tuple(labels)


def _moving_picture(shown: "Result") -> MovingPicture | str:
    """The picture; of a machine without its model file, which alone has it, the reason."""
    try:
        return moving_picture(shown)
    except LinkwrightError as error:
        return str(error)
