"""The folder of generated modules; numba's cache beside them outlives a run."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def workshop(request: pytest.FixtureRequest) -> Path:
    """A folder of models and their generated modules."""
    folder: Path = request.config.cache.mkdir("machines-in-space")
    return folder
