"""The hard cases with kernels in another form: ``pytest tests/hard --unroll never``."""

from collections.abc import Iterator

import pytest

from tests.unrolling import built_with


@pytest.fixture(scope="session", autouse=True)
def form_of_kernels(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[None]:
    """With ``--unroll``, machines of the library are built anew in a folder of the session."""
    unroll = request.config.getoption("--unroll")
    if unroll == "auto":
        yield
        return
    with built_with(unroll, tmp_path_factory.mktemp("generated")):
        yield
