"""The command `linkwright draw`: a machine as a picture in a file."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.figures_and_html import check_parent, save_figure
from codegen.files.whole_files import whole_file

ENDINGS = (".png", ".svg", ".pdf")


def save_drawing(
    model: str, scene: str | None, t: float | None, parameters: Mapping[str, float], out: Path,
    progress: Callable[[str], object], *, generated: Path | None = None, **drawing: Any,
) -> Path:  # fmt: skip
    """Draw a machine and save the picture.

    Parameters
    ----------
    model, scene, parameters
        The declaration, one of its scenes, and values in place of the defaults.
    t
        The instant in s at which the machine is assembled; this compiles the scene. Without it the
        declaration is drawn at its start, and nothing is compiled.
    drawing
        Options of `Model.draw`.

    Raises
    ------
    InputError
        If the declaration is wrong, if the joints do not close at `t`, or if the picture cannot be
        written.
    """
    if out.suffix.lower() not in ENDINGS:
        raise InputError(f"--out {out}: a picture ends in .png, .svg or .pdf.")
    check_parent(out)
    progress("drawing")
    if t is None:
        from codegen.reading.model_file import read_model

        figure = read_model(model).model.draw(scene, parameters=parameters, **drawing)
    else:
        from runtime.machine_loading import load

        if not drawing.pop("assembled"):
            raise InputError("--guesses with --t: at an instant joints are closed; leave one out.")
        machine = load(model, scene, generated=generated)
        figure = machine.draw(t, parameters=parameters, **drawing)
    with whole_file(out) as temporary:
        save_figure(figure, temporary)
    return out
