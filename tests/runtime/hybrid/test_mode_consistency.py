"""Preferred modes are stored with a mark that they are decided."""

import pytest

from runtime.core.kinds import Mode
from runtime.hybrid.mode_consistency import decided_entry, preferred_mode


@pytest.mark.parametrize("mode", [Mode.OFF, Mode.ON, Mode.SLIDING])
def test_a_mark_keeps_the_mode(mode):
    decided = float(decided_entry.py_func(mode))
    assert preferred_mode.py_func(decided) == preferred_mode.py_func(float(mode)) == mode
    assert decided not in set(Mode)
