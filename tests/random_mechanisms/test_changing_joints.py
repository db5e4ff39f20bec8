"""Random machines whose joints come and go at one instant, with contacts, clutches and drivers.

500 by hand, in half an hour: `python -m tests.random_mechanisms.changing_joints_campaign 0 500`.
"""

from pathlib import Path

import pytest

from tests.random_mechanisms.changing_joints import random_machine, rounds
from tests.random_mechanisms.changing_joints_campaign import judge


@pytest.mark.parametrize("seed", range(12))
def test_joints_change_together_in_any_order_of_declaration(seed: int, tmp_path: Path) -> None:
    assert judge(random_machine(seed), tmp_path) == []


def test_machines_are_of_many_kinds() -> None:
    machines = [random_machine(seed) for seed in range(60)]
    done = [rounds(one)[0] for one in machines]
    assert sum(len(each) > 1 for each in done) > 5  # impacts that make others happen
    assert sum(bool(one.walls) for one in machines) > 5
    assert sum(one.clutch is not None for one in machines) > 5
    assert sum(any(joint.acts for joint in each[0].changed) for each in done) > 20
    assert sum(any(not joint.acts for joint in each[0].changed) for each in done) > 20
