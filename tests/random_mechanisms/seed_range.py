"""A campaign: machines of a range of seeds are judged, and what differs is said."""

import argparse
import sys
import time
from collections.abc import Callable, Iterable

Judge = Callable[[int], tuple[Iterable[str], str]]


def run_campaign(description: str | None, judge: Judge, **others: Judge) -> None:
    """Judge the seeds of the command line; `judge` returns complaints and a word on the machine.

    An option with the name of one of the `others` takes that one.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    for name, other in others.items():
        parser.add_argument(f"--{name}", dest="judge", action="store_const", const=other)
    parser.set_defaults(judge=judge)
    chosen = parser.parse_args()
    differ = 0
    for seed in range(chosen.first, chosen.last):
        began = time.perf_counter()
        complaints, about = chosen.judge(seed)
        complaints = [*complaints]
        differ += bool(complaints)
        spent = time.perf_counter() - began
        lines = [f"{seed}: {'differs' if complaints else 'agrees'}, {spent:.1f} s{about}"]
        sys.stdout.write("\n  ".join([*lines, *complaints]) + "\n")
        sys.stdout.flush()
    sys.stdout.write(f"{differ} of {chosen.last - chosen.first} differ\n")
