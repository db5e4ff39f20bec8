"""Springs whose ends move within the ground, in movies and figures."""

import numpy as np
import pytest

from codegen.drawing.matplotlib_painter import PictureArtist
from codegen.drawing.motion_figure import MovieFigure
from codegen.drawing.shapes import Spring
from runtime.show.movie import gif_rate
from tests.runtime.show.animation.machines import pushed_crank, spring_on_a_shaker


def test_frames_have_the_places_of_their_instants() -> None:
    t = np.linspace(0.0, 3.0, 7)
    frames = spring_on_a_shaker(t).frames()
    springs = [frame.symbols[1].shape for frame in frames]
    assert all(isinstance(shape, Spring) for shape in springs)
    assert [shape.i.x for shape in springs] == pytest.approx(2.0 + 0.5 * np.sin(t))


def test_frames_have_the_forces_of_their_instants() -> None:
    t = np.linspace(0.0, 1.0, 4)
    frames = pushed_crank(t, 1.0 + t).frames()
    assert [frame.symbols[1].shape.fx for frame in frames] == pytest.approx(1.0 + t)


def test_walls_go_with_the_ends_of_springs() -> None:
    frames = spring_on_a_shaker(np.array([0.0, np.pi / 2])).frames()
    artist = PictureArtist(frames[0])
    rails = [
        [p.stroke.points.mean() for p in artist.painted(frame) if p.stroke.style == "rail"]
        for frame in frames
    ]
    moved = np.array(rails[1]) - np.array(rails[0])
    assert moved[-1] == pytest.approx(0.5)
    assert np.abs(moved[0]).max() == 0.0  # the support of the crank


def test_a_movie_has_one_artist_for_all_frames() -> None:
    shown = spring_on_a_shaker(np.linspace(0.0, 3.0, 4))
    frames = shown.frames()
    movie = MovieFigure(frames, 300, shown.motion)
    pixels = [movie.pixels(k, "").astype(int).copy() for k in range(len(frames))]
    assert len(movie.artists) == 1
    assert np.count_nonzero(pixels[1] - pixels[0]) > 50


@pytest.mark.parametrize(("wanted", "rate"), [(30, 100 / 3), (24, 25), (60, 50), (240, 50), (1, 1)])
def test_a_gif_has_frames_of_whole_hundredths(wanted: int, rate: float) -> None:
    assert gif_rate(wanted) == pytest.approx(rate)
