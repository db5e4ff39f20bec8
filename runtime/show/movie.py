"""The motion of a result as a movie (.mp4, .gif), or as one figure of several positions (.svg)."""

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.matplotlib_painter import MovieFigure, phase_figure
from codegen.errors import InputError
from codegen.files.whole_files import whole_file
from codegen.presentation import MOVIES, is_movie, save_figure
from runtime.progress_bar import bar
from runtime.show.pictures import moving_picture

if TYPE_CHECKING:
    from runtime.results.result import Result

FRAMES_A_SECOND, WIDTH, PHASES = 30, 960, 6  # layout: of a movie, in 1/s and pixels; of a figure
SHORTEST, LONGEST, USUAL = 2.0, 60.0, 10.0  # layout: s, of movies that run as fast as the machine
MOST_FRAMES = 20_000  # safety: a longer movie is more likely a wrong speed than wanted
GIF_RATE = 50  # layout: most frames a second that viewers of .gif show
_GIF_TICKS = 100  # layout: of a second, in which a .gif counts how long a frame stays
_GIF_BYTES = 2 * 1024**3  # safety: memory for the frames of a .gif, which is written at the end
_INSTALL = "pip install 'linkwright[movie]', in the checkout pip install '.[movie]'"

Pixels = npt.NDArray[np.uint8]


def save_movie(
    result: "Result", file: Path, *, frames_per_second: int | None = None,
    width: int | None = None, speed: float | None = None, span: tuple[float, ...] | None = None,
    progress: bool = True,
) -> Path:  # fmt: skip
    """Write the motion of a result, whole or not at all.

    Parameters
    ----------
    file
        Ends in .mp4 (by ffmpeg), .gif, or .svg: a still of some positions over each other.
    frames_per_second
        Of the movie, 30 unless given; a .gif has 50 at most. Of an .svg: no meaning.
    width
        In pixels, 960 unless given.
    speed
        Seconds of the machine in a second of the movie. Unless given, 1 where the movie then takes
        2 s to 60 s, and otherwise what makes it 10 s long.
    span
        First and last instant, s; unless given, the whole result.
    progress
        Whether a terminal shows a bar.

    Raises
    ------
    InputError
        With all that is wrong: an ending, a number, a span without motion; if Matplotlib or ffmpeg
        is missing, or the file cannot be written.
    """
    first, last = _span(result, span)
    problems = []
    if file.suffix.lower() == ".mp4":
        ffmpeg()  # before all that takes time
    if not is_movie(file):
        problems.append(f"{file.name}: a movie ends in {', '.join(MOVIES)}, a page in .html.")
    if not last > first:
        problems.append(
            f"{result.description.title}: there is no motion between {first:.6g} s and "
            f"{last:.6g} s ({result.message or 'one instant'}). A picture is drawn by "
            "result.draw()."
        )
    if problems:
        raise InputError(problems)
    ending = file.suffix.lower()
    if ending == ".svg":
        shown = moving_picture(result, result.at(np.linspace(first, last, PHASES)))
        with whole_file(file) as target:
            save_figure(phase_figure(shown.frames()), target)
        return file
    rate: float = frames_per_second or FRAMES_A_SECOND
    rate = gif_rate(rate) if ending == ".gif" else rate
    pace = speed or usual_speed(last - first)
    count = max(2, round((last - first) / pace * rate) + 1)
    if count > MOST_FRAMES:
        raise InputError(
            f"{file.name}: {count} frames, from {first:.6g} s to {last:.6g} s at speed={pace:.6g} "
            f"and {rate:.4g} frames a second; the most are {MOST_FRAMES}. Give a higher speed=, a "
            "shorter span=, or a lower frames_per_second=."
        )
    instants = np.linspace(first, last, count)
    movie = MovieFigure(moving_picture(result, result.at(instants)).frames(), width or WIDTH)
    wide, high = movie.size
    if ending == ".gif" and count * wide * high > _GIF_BYTES:
        raise InputError(
            f"{file.name}: {count} frames of {wide} by {high} pixels are more than the "
            f"{_GIF_BYTES >> 20} MiB that a .gif may take of the memory. Give a smaller width=, a "
            "lower frames_per_second=, a higher speed=, a shorter span=, or write an .mp4."
        )
    scale = "" if pace == 1.0 else f",  speed × {pace:.3g}"
    write = _write_gif if ending == ".gif" else _write_mp4
    with bar(f"drawing {file.name}", progress) as report, whole_file(file) as target:

        def drawn() -> Iterator[Pixels]:
            for k, t in enumerate(instants):
                yield movie.pixels(k, f"t = {t:.3f} s{scale}")
                report((k + 1) / count)

        write(target, movie.size, rate, drawn())
    return file


def usual_speed(duration: float) -> float:
    """Seconds of the machine in a second of a movie, for a motion that takes `duration`, s."""
    return 1.0 if SHORTEST <= duration <= LONGEST else duration / USUAL


def gif_rate(rate: float) -> float:
    """The frames a second nearest to a wanted rate that a .gif can have: 100 over a whole number.

    It counts in hundredths of a second, and viewers slow frames of less than two down.
    """
    return _GIF_TICKS / max(round(_GIF_TICKS / rate), _GIF_TICKS // GIF_RATE)


def _span(result: "Result", span: tuple[float, ...] | None) -> tuple[float, float]:
    if span is not None:
        if len(span) != 2:
            raise InputError(f"span= has {len(span)} numbers; give the first and last instant, s.")
        return span[0], span[1]
    return (float(result.t[0]), float(result.t[-1])) if len(result.t) else (0.0, 0.0)


def _write_mp4(target: Path, size: tuple[int, int], rate: float, frames: Iterable[Pixels]) -> None:
    """Write a file of H.264, whose frames ffmpeg takes from a pipe."""
    command = [
        ffmpeg(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgba",
        "-s", f"{size[0]}x{size[1]}", "-r", f"{rate:g}", "-i", "-", "-an",
        "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", str(target),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        pipe: Any = process.stdin
        try:
            for pixels in frames:
                pipe.write(np.ascontiguousarray(pixels))
            pipe.close()
        except BrokenPipeError:  # ffmpeg has given up, and says why
            pass
        except BaseException:
            process.kill()
            raise
        said = process.stderr.read().decode(errors="replace").strip() if process.stderr else ""
        if process.wait() != 0:
            raise InputError(f"ffmpeg could not write the movie: {said or 'no message'}")


def ffmpeg() -> str:
    """The program ffmpeg: the system's, or that of the package imageio-ffmpeg."""
    found = shutil.which("ffmpeg")
    if found is None:
        try:
            from imageio_ffmpeg import get_ffmpeg_exe

            found = get_ffmpeg_exe()
        except (ImportError, RuntimeError) as error:
            raise InputError(
                f"An .mp4 needs the program ffmpeg, which is not installed. Install it, or run "
                f"{_INSTALL}; a .gif needs neither."
            ) from error
    return str(found)


def _write_gif(target: Path, size: tuple[int, int], rate: float, frames: Iterable[Pixels]) -> None:
    """Write a .gif with the colours of its first frame."""
    from PIL import Image

    images: list[Any] = []
    for pixels in frames:
        palette = {"palette": images[0]} if images else {"colors": 128}
        image = Image.fromarray(pixels).convert("RGB")
        images.append(image.quantize(**palette, dither=Image.Dither.NONE))
    images[0].save(target, save_all=True, append_images=images[1:], loop=0, optimize=False,
                   duration=round(1000 / rate))  # fmt: skip
