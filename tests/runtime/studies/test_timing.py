"""Timing: runs take turns, and one that is cut short has no time."""

import pytest

from runtime.studies.timing import Stopwatch, TimeLimit, processor_time, take_turns, time_to_error


def test_runs_take_turns_until_each_is_finished() -> None:
    order: list[str] = []

    def run(name: str) -> float:
        order.append(name)
        return float(len(order))

    watches = [Stopwatch(lambda name=name: run(name)) for name in "ab"]
    take_turns(watches, lambda watch: len(watch.times) >= (3 if watch is watches[0] else 2))
    assert order == list("ababa")
    assert watches[0].times == [1.0, 3.0, 5.0]
    assert (watches[0].seconds, watches[0].spread) == (1.0, 3.0)


def test_a_run_that_is_cut_short_has_no_time() -> None:
    seconds = iter([3.0, None])
    watch = Stopwatch(lambda: next(seconds))
    take_turns([watch], lambda _: False)
    assert watch.times == [3.0]


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
