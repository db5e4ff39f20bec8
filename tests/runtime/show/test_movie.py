"""Movies: which frames they have, how long they are, and what is refused."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from codegen.drawing.matplotlib_painter import MovieFigure, PictureArtist, phase_figure
from codegen.drawing.shapes import Spring
from codegen.errors import InputError
from runtime import load
from runtime.results.result import Result
from runtime.show import movie
from runtime.show.movie import gif_rate, save_movie, usual_speed
from runtime.show.pictures import moving_picture
from tests.runtime.show.animation.machines import pushed_crank, spring_on_a_shaker


@pytest.fixture(scope="module")
def run() -> Result:
    return load("slider_crank", "compressor").simulate(0.7, 15, progress=False)


def test_a_gif_has_the_frames_and_the_time_of_the_motion(run: Result, tmp_path: Path) -> None:
    file = run.animate(tmp_path / "run.gif", frames_per_second=10, width=300, speed=0.5,
                      span=(0.2, 0.6), progress=False)  # fmt: skip
    with Image.open(file) as image:
        assert image.n_frames == 9
        assert image.size[0] == 300
        assert image.info["duration"] == 100
        first = np.asarray(image.convert("RGB"), dtype=int)
        image.seek(8)
        assert np.count_nonzero(first - np.asarray(image.convert("RGB"), dtype=int)) > 100


def test_an_mp4_is_one(run: Result, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    from imageio_ffmpeg import count_frames_and_secs

    file = save_movie(run, tmp_path / "run.mp4", width=320, span=(0.0, 0.3), speed=1.0)
    assert file.read_bytes()[4:8] == b"ftyp"
    assert count_frames_and_secs(file)[0] == 10


def test_frames_differ_by_the_poses_alone(run: Result) -> None:
    figure = MovieFigure(moving_picture(run, run.at([0.0, 0.4])).frames(), 320)
    width, height = figure.size
    assert width == 320
    assert height % 2 == 0
    first, second = (figure.pixels(k, "").astype(int).copy() for k in (0, 1))
    assert first.shape == (height, width, 4)
    assert np.count_nonzero(first - second) > 100
    assert np.array_equal(figure.pixels(0, "").astype(int), first)
    assert len(figure.artists) == 1


def test_a_movie_of_a_span_has_the_guides_of_the_whole_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The compressor's slider sees more of its guide in the whole run than in a hundredth of it."""
    result = load("slider_crank", "compressor").simulate(1.0, 101, progress=False)
    made: list[MovieFigure] = []

    class Kept(MovieFigure):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            made.append(self)

    monkeypatch.setattr(movie, "MovieFigure", Kept)
    save_movie(result, tmp_path / "run.gif", width=320, span=(0.0, 0.01), progress=False)
    lengths = []
    (figure,) = made
    (frame,) = moving_picture(result, result.at([0.0])).frames()
    own = PictureArtist(frame), PictureArtist(replace(frame, motion=frame.poses[None]))
    for artist in (*figure.artists.values(), *own):
        rails = [stroke.points for stroke in artist.rigid if stroke.style == "rail"]
        lengths.append(max(float(np.ptp(rail.real)) for rail in rails))
    in_movie, in_run, at_start = lengths
    assert in_movie == pytest.approx(in_run)
    assert in_movie > 1.1 * at_start


def test_an_svg_has_several_positions_that_grow_stronger(run: Result, tmp_path: Path) -> None:
    text = save_movie(run, tmp_path / "run.svg").read_text(encoding="utf-8")
    assert text.count('<g id="PathCollection_') == movie.PHASES
    figure = phase_figure(moving_picture(run, run.at([0.0, 0.2, 0.4])).frames())
    edges = [c.get_edgecolors() for c in figure.axes[0].collections]
    shades = [float(colors[colors[:, 3] > 0, :3].min()) for colors in edges]
    assert shades == sorted(shades, reverse=True)
    assert len(set(shades)) == 3


def test_symbols_that_do_not_act_are_left_out(run: Result) -> None:
    first, *others = moving_picture(run).symbols
    later = replace(moving_picture(run), symbols=(replace(first, spans=((0.5, 9.0),)), *others))
    counts = [len(frame.symbols) for frame in later.frames()]
    assert [counts[0], counts[-1]] == [len(others), len(others) + 1]


@pytest.mark.parametrize(
    ("file", "words", "message"),
    [
        ("a.avi", {}, "a movie ends in .mp4, .gif, .svg"),
        ("a.gif", {"frames_per_second": 500}, "frames_per_second is 500; it must be a whole"),
        ("a.gif", {"width": 10}, "width is 10; it must be a whole number"),
        ("a.gif", {"speed": -1.0}, "speed is -1.0; it must be a positive number"),
        ("a.gif", {"span": (0.1, 0.2, 0.3)}, "span= has 3 numbers"),
        ("a.html", {"speed": 2.0}, "are those of a movie"),
        ("a.gif", {"span": (0.5, 0.5)}, "there is no motion between 0.5 s and 0.5 s"),
        ("a.gif", {"speed": 1e-6}, "Give a higher speed="),
        ("nowhere/a.gif", {"span": (0.0, 0.1)}, "cannot write"),
    ],
)
def test_what_cannot_be_a_movie_is_refused(
    run: Result, tmp_path: Path, file: str, words: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        run.animate(tmp_path / file, **words)
    assert list(tmp_path.iterdir()) == []


def test_the_memory_of_a_gif_is_that_of_its_frames(
    run: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words: dict[str, Any] = {"width": 320, "span": (0.0, 0.2), "speed": 1.0, "progress": False}
    part = run.at(np.linspace(0.0, 0.2, 8))
    wide, high = MovieFigure(moving_picture(run, part).frames(), 320).size
    monkeypatch.setattr(movie, "_GIF_BYTES", 8 * wide * high)  # at 100 / 3 frames a second
    assert save_movie(run, tmp_path / "a.gif", **words).exists()
    monkeypatch.setattr(movie, "_GIF_BYTES", 8 * wide * high - 1)
    advice = rf"8 frames of 320 by {high} pixels.*lower frames_per_second=.*or write an \.mp4"
    with pytest.raises(InputError, match=advice):
        save_movie(run, tmp_path / "b.gif", **words)


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_too_many_frames_are_refused_without_advice_on_another_file(
    run: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    monkeypatch.setattr(movie, "ffmpeg", lambda: "false")
    with pytest.raises(
        InputError, match=r"the most are 20000\..*span=, or a lower frames_per"
    ) as e:
        save_movie(run, tmp_path / f"run.{ending}", speed=1e-6)
    assert "width" not in str(e.value)


def test_all_that_is_wrong_is_said_at_once(run: Result, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"(?s)ends in.*no motion between 2 s and 1 s"):
        save_movie(run, tmp_path / "a.mov", span=(2.0, 1.0))


def test_without_ffmpeg_the_message_says_what_to_install(
    run: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(movie.shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match="pip install 'linkwright\\[movie\\]'"):
        save_movie(run, tmp_path / "a.mp4", span=(0.0, 0.1))
    assert list(tmp_path.iterdir()) == []


def test_a_movie_that_ffmpeg_cannot_write_says_what_it_said(
    run: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(movie, "ffmpeg", lambda: "false")
    with pytest.raises(InputError, match="ffmpeg could not write the movie"):
        save_movie(run, tmp_path / "a.mp4", span=(0.0, 0.1))
    assert list(tmp_path.iterdir()) == []


def test_frames_have_the_places_and_forces_of_their_instants() -> None:
    t = np.linspace(0.0, 3.0, 7)
    springs = [frame.symbols[1].shape for frame in spring_on_a_shaker(t).frames()]
    assert all(isinstance(shape, Spring) for shape in springs)
    assert [shape.i.x for shape in springs] == pytest.approx(2.0 + 0.5 * np.sin(t))
    pushed = pushed_crank(t, 1.0 + t).frames()
    assert [frame.symbols[1].shape.fx for frame in pushed] == pytest.approx(1.0 + t)


def test_walls_go_with_the_ends_of_springs() -> None:
    frames = spring_on_a_shaker(np.array([0.0, np.pi / 2])).frames()
    artist = PictureArtist(frames[0])
    rails = [
        [stroke.points.mean() for stroke in artist.strokes(frame) if stroke.style == "rail"]
        for frame in frames
    ]
    moved = np.array(rails[1]) - np.array(rails[0])
    assert moved[-1] == pytest.approx(0.5)
    assert np.abs(moved[0]).max() == 0.0  # the support of the crank


def test_movies_have_a_usual_length_and_gifs_whole_hundredths() -> None:
    assert [usual_speed(span) for span in (0.1, 5.0, 300.0)] == pytest.approx([0.01, 1.0, 30.0])
    rates = [gif_rate(wanted) for wanted in (30, 24, 60, 240, 1)]
    assert rates == pytest.approx([100 / 3, 25, 50, 50, 1])
