"""An animation of one run or several: shown in a notebook, saved as a page.

Its instants are those of frames, both sides of every event, and more where it is fast.
"""

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.picture import Picture
from codegen.errors import InputError, LinkwrightError
from codegen.files.model_text import plain, read_model_text
from codegen.files.whole_files import whole_file
from codegen.presentation import is_movie, is_page
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class
from runtime.results.motion_at_instants import Sampling, resampled, thinned
from runtime.show.animation.page_data import (
    NO_MACHINE,
    NO_MACHINE_IN_SPACE,
    block,
    event_marks,
    in_two,
    machine_data,
    unit_for,
)
from runtime.show.animation.page_text import curves, framed, page_text, require_bokeh
from runtime.show.pictures import exerted, moving_picture

if TYPE_CHECKING:
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

_VALUES = 600_000  # layout: numbers of a run in a page, some 2 MB
_VALUES_IN_SPACE = 260_000  # layout: the same beside three.js, so that a page stays below 1.5 MB
RATE = 60  # layout: frames a second of the run's own time
TURN = 0.15  # accuracy: rad between instants; a straight path between them errs by 0.3 % of an arm
_MAX_FAST = 20_000  # layout: instants of a run whose bodies turn fast
_SAMPLING = Sampling(
    a_step=2,  # layout: instants in a step of the run
    least=600,  # layout: instants of a short run
    most=6000,  # layout: instants of a long one, so that a page stays below some MB
    events=1000,  # layout: events of which both sides are shown
    patience=10.0,  # measured: s of integration that an animation takes once more
)
_HEIGHT = 720  # layout: of the frame in a notebook, px
_DRIVEN = ("kinematics", "inverse dynamics")
"""The analyses of a motion that drivers prescribe, which may be gone through by hand."""
MAX_RUNS = 6  # layout: runs beside each other


@checked_class
class Animation:
    """A machine in motion with its curves, as a self-contained page.

    A notebook shows it, also after the export to HTML.

    Attributes
    ----------
    title
        Model and scene.
    labels
        One text for each run, which distinguishes it from the others.
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
        unit = unit_for(max(machine.size for machine, _ in machines))
        runs = []
        for number, (run, (machine, missing)) in enumerate(zip(shown, machines, strict=True)):
            series, groups = curves(run)
            marks = event_marks(self._results[number])
            runs.append({
                "label": self.labels[number], "title": run.description.title, "t": in_two(run.t),
                "series": series, "groups": groups, "missing": missing,
                "driven": self._results[number].analysis in _DRIVEN,
                **machine_data(machine, unit, exerted(run), marks),
                **({"notUnique": self._results[number].not_unique} if is_in_space(run) else {}),
            })  # fmt: skip
        has_curves = any(len(result.t) > 1 for result in self._results)
        words = " ".join(dict.fromkeys(map(about, shown)))
        return page_text(
            self.title, block({"runs": runs}), self._below, words,
            has_curves=has_curves, runs=len(runs), in_space=is_in_space(self._results[0]),
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
    results: "Sequence[Result]", *, file: str | os.PathLike[str] | None = None,
    labels: Sequence[str] = (),
) -> Animation:  # fmt: skip
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
    if len({is_in_space(run) for run in runs}) > 1:
        problems.append(
            "animate: machines in the plane and in space are seen in different ways; animate them "
            "in pages of their own."
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


def about(result: "Result") -> str:
    """What the docstring of a model file says of the machine and of its scene; "" without one."""
    origin = result._mechanism.origin if result._mechanism else None
    text = read_model_text(origin.model) if origin and isinstance(origin.model, Path) else None
    scene = text.scenes.get(result.description.scene, "") if text else ""
    return plain(f"{text.summary} {scene}".strip()) if text else ""


def differences(results: "Sequence[Result]") -> tuple[str, ...]:
    """What tells runs apart: scenes, analyses and parameters in which they differ, or a number."""
    facts: list[dict[str, Any]] = [
        {" title": run.description.title, " analysis": run.analysis, **run.parameters}
        for run in results
    ]
    first = facts[0]
    names = [name for name in first if any(one.get(name) != first[name] for one in facts)]
    labels = tuple(
        ", ".join(
            one[name] if isinstance(one[name], str) else f"{name} = {one[name]:.6g}"
            for name in names
            if name in one
        )
        for one in facts
    )
    if len(set(labels)) == len(results):
        return labels
    return tuple(f"run {k + 1}" for k in range(len(results)))


def _moving_picture(shown: "Result") -> tuple[Picture, str]:
    """The picture; of a machine without its model file, which alone has it, none and the reason."""
    try:
        return moving_picture(shown), ""
    except LinkwrightError as error:
        return NO_MACHINE_IN_SPACE if is_in_space(shown) else NO_MACHINE, str(error)


def is_in_space(result: "Result") -> bool:
    """Whether the machine of a result is in space."""
    return bool(result.description.turning)


def animated(result: "Result") -> "Result":
    """The result at the instants of its frames; of a run that took long, its own samples.

    Between two instants no body turns by more than `TURN`, if the page has room for so many; else
    those that are added lie at equal turns.
    """
    span = float(np.ptp(result.t)) if len(result.t) else 0.0
    known = result.description
    # About so many numbers a page has of an instant: motion twice, reactions, powers; in space also
    # the components of what drivers and effects exert.
    columns = 4 * len(known.coordinates) + len(known.reactions) + len(known.powers) + 4
    columns += 3 * len(known.drivers) + 6 * len(known.effects) if is_in_space(result) else 0
    room = (_VALUES_IN_SPACE if is_in_space(result) else _VALUES) / columns
    fewest = int(min(room, _SAMPLING.least)) if is_in_space(result) else _SAMPLING.least
    most = int(np.clip(room, fewest, _SAMPLING.most))
    least = int(np.clip(RATE * span, fewest, most))
    sampling = _SAMPLING._replace(least=least, most=most)
    even = resampled(result, sampling)
    limit = int(np.clip(room, most, _MAX_FAST))
    between = instants_between(even.t, turns(even), limit - len(even.t))
    found = resampled(result, sampling, between) if len(between) else even
    return thinned(found, limit) if is_in_space(result) else found


def turns(result: "Result") -> FloatArray:
    """The largest turn of a body between neighbouring instants, (k - 1,), rad."""
    positions = result.description.positions
    angles = [result.q(row.name) for row in positions if row.unit == "rad"]
    if is_in_space(result) and len(result.t) > 1:
        rates = [result.samples.v[:, k : k + 4] for _, k in result.description.turning]
        omega = np.nan_to_num(2.0 * np.linalg.norm(rates, axis=-1).max(axis=0))
        return np.asarray(np.maximum(omega[1:], omega[:-1]) * np.diff(result.t))
    if not angles or len(result.t) < 2:
        return np.zeros(max(len(result.t) - 1, 0))
    change = np.abs(np.diff(np.array(angles), axis=1))
    return np.asarray(np.where(np.isfinite(change), change, 0.0).max(axis=0))


def instants_between(t: FloatArray, turned: FloatArray, room: int) -> FloatArray:
    """Instants to add between those of `t`, (k,), no more than `room`, s.

    Parameters
    ----------
    turned : (k - 1,)
        The turn from each instant to the next, rad. Those above `TURN` are parted: each into equal
        parts of at most `TURN`, or, without the room for them, all together into equal parts.
    """
    parts = np.maximum(np.ceil(turned / TURN).astype(int), 1)
    if np.sum(parts - 1) <= room:
        split = [np.linspace(t[k], t[k + 1], parts[k] + 1)[1:-1] for k in np.flatnonzero(parts > 1)]
        return np.concatenate([np.empty(0), *split])
    whole = np.cumsum([0.0, *np.where(parts > 1, turned, 0.0)])
    return np.interp(np.linspace(0.0, whole[-1], max(room, 0) + 2)[1:-1], whole, t)
