"""Files without what this version writes are refused, and told from those of another model."""

from pathlib import Path
from typing import Any

import pytest

from codegen import Model
from codegen.errors import InputError
from runtime import load, load_result
from runtime.machine_facade import Machine
from runtime.results import export
from runtime.results.result import Result
from runtime.results.saved_result import pack, saved_fields


@pytest.fixture(scope="module")
def dropped(workshop: Path) -> Machine:
    model = Model("older_file", gravity=(0, -9.81))
    ball = model.particle("ball", 1.0)
    rail = model.absolute("rail", ball, "x", 0.0)
    model.release(rail, when=ball.y < -0.1)
    model.scene("falls", ["gravity"], start={ball.y: 0.0, ball.vy: 0.0})
    return load(model, folder=workshop)


@pytest.mark.parametrize("t_end", [0.1, 0.5])  # before the release, and behind it
@pytest.mark.parametrize(
    "missing", [("until",), ("motion", "source", "content"), ("motion",), ("title",)]
)
def test_a_file_that_lacks_a_field(
    dropped: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, t_end: float,
    missing: tuple[str, ...],
) -> None:  # fmt: skip
    def older(result: Result) -> bytes:
        place: dict[str, Any] = saved_fields(result)
        whole = place
        for name in missing[:-1]:
            place = place[name]
        del place[missing[-1]]
        return pack(whole)

    r = dropped.simulate(t_end)
    assert len(r.reconnections) == (t_end == 0.5)
    monkeypatch.setattr(export, "saved_result", older)
    with pytest.raises(InputError, match="not written by this version of Result"):
        load_result(r.save(tmp_path / "older.nc"), dropped)
