"""A campaign: machines of a range of seeds are judged, and what differs is said."""

import argparse
import sys
import time
from collections.abc import Callable, Iterable


def run_campaign(
    description: str | None, judge: Callable[[int], tuple[Iterable[str], str]]
) -> None:
    """Judge the seeds of the command line; `judge` returns complaints and a word on the machine."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    chosen = parser.parse_args()
    differ = 0
    for seed in range(chosen.first, chosen.last):
        began = time.perf_counter()
        complaints, about = judge(seed)
        complaints = [*complaints]
        differ += bool(complaints)
        spent = time.perf_counter() - began
        lines = [f"{seed}: {'differs' if complaints else 'agrees'}, {spent:.1f} s{about}"]
        sys.stdout.write("\n  ".join([*lines, *complaints]) + "\n")
        sys.stdout.flush()
    sys.stdout.write(f"{differ} of {chosen.last - chosen.first} differ\n")
