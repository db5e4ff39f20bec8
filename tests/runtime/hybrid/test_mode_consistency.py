"""Preferred modes are stored with a mark that they are known."""

import pytest

from runtime.core.modes import Mode
from runtime.hybrid.mode_consistency import mark_known, preferred_mode


@pytest.mark.parametrize("mode", [Mode.OFF, Mode.ON, Mode.SLIDING])
def test_a_mark_keeps_the_mode(mode):
    known = float(mark_known.py_func(mode))
    assert preferred_mode.py_func(known) == preferred_mode.py_func(float(mode)) == mode
    assert known not in set(Mode)
