"""Timing: runs take turns, and one that is cut short has no time."""

import pytest

from runtime.studies.timing import TimeLimit, processor_time, time_runs, time_to_error


def test_runs_take_turns_and_one_that_is_cut_short_ends() -> None:
    order: list[str] = []

    def run(name: str) -> float | None:
        order.append(name)
        return None if order.count("b") == 2 and name == "b" else float(len(order))

    runs = [lambda name=name: run(name) for name in "abc"]
    times = time_runs(runs, [0.5] * 3, 3, 0.6)
    assert order == list("abcabc")
    assert times == [[1.0, 4.0], [2.0], [3.0, 6.0]]


@pytest.mark.parametrize(
    ("took", "first", "rounds", "least", "count"),
    [
        (0.5, 0.5, 5, 1.0, 5),
        (0.01, 0.01, 5, 1.0, 30),
        (2.0, 2.0, 5, 1.0, 2),
        (2.0, 2.0, 3, 0.0, 3),
        (0.1, float("nan"), 3, 0.0, 3),
    ],
)
def test_runs_are_repeated_for_a_time(
    took: float, first: float, rounds: int, least: float, count: int
) -> None:
    assert time_runs([lambda: took], [first], rounds, least) == [[took] * count]


def test_a_run_that_is_cut_short_keeps_its_first_time() -> None:
    assert time_runs([lambda: None], [0.2], 5, 1.0) == [[0.2]]


def test_a_time_limit_counts_from_the_first_sign_of_life() -> None:
    limit = TimeLimit(0.0)
    limit(0.0)
    assert not limit.exceeded
    with pytest.raises(KeyboardInterrupt):
        limit(0.5)
    assert limit.exceeded


def test_processor_time_comes_with_the_answer() -> None:
    answer, seconds = processor_time(lambda: sum(range(1000)))
    assert answer == 499500
    assert seconds >= 0.0


@pytest.mark.parametrize(("error", "seconds"), [(1e-3, 2.0), (0.1, 1.0), (1e-5, None)])
def test_times_to_an_error_lie_on_lines_in_logarithms(error: float, seconds: float | None) -> None:
    assert time_to_error([(1e-2, 1.0), (1e-4, 4.0)], error) == pytest.approx(seconds)
    assert time_to_error([], error) is None
