"""A sample of the campaign in space: random mechanisms that are built, run and compared."""

import pytest

from tests.random_mechanisms.spatial_campaign import judge


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 4, 6])
def test_a_run_agrees_with_newton_and_euler(seed: int) -> None:
    """Loops of which rows follow from others; 4 by an implicit method, too."""
    complaints, about = judge(seed)
    assert complaints == (), about
