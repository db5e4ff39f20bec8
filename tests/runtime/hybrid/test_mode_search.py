"""Every mode of a function is a choice, once; preferred modes come first."""

import pytest

from runtime.core.kinds import Mode
from runtime.hybrid.mode_selection import choose_mode


@pytest.mark.parametrize("preferred", [Mode.OFF, Mode.ON, Mode.SLIDING])
def test_a_function_has_three_modes(preferred):
    chosen = [choose_mode.py_func(False, preferred, choice) for choice in range(3)]
    assert chosen[0] == preferred
    assert sorted(chosen) == [Mode.OFF, Mode.ON, Mode.SLIDING]


@pytest.mark.parametrize("preferred", [Mode.ON, Mode.SLIDING])
def test_a_rigid_contact_is_open_or_closed(preferred):
    chosen = [choose_mode.py_func(True, preferred, choice) for choice in range(3)]
    assert chosen[0] == preferred
    assert sorted(chosen) == [-1, Mode.ON, Mode.SLIDING]
