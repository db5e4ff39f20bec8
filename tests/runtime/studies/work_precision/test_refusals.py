"""Arguments and reference files that are refused before anything runs."""

from pathlib import Path
from typing import Any

import pytest

from codegen.errors import InputError
from runtime import accuracy


@pytest.mark.parametrize(
    ("scene", "options", "message"),
    [
        ("swing", {"quantities": ("body.fi",)}, "There is no series 'body.fi'; nearest: body.phi"),
        ("swing", {"quantities": ("a.x|b.x",)}, "There is no series 'a.x'"),
        ("swing", {"quantities": "body.x"}, "quantities is 'body.x'; it must be a sequence"),
        ("swing", {"methods": "dop853"}, "methods is 'dop853'; it must be a sequence"),
        ("swing", {"formulations": "reduced"}, "formulations is 'reduced'; it must be a sequence"),
        ("swing", {"beside": "rubbing"}, "beside is 'rubbing'; it must be a sequence"),
        ("swing", {"t_end": None}, "t_end is missing"),
        ("swing", {"t_end": -1.0}, "from 0 to -1 s must be finite and positive"),
        ("swing", {"methods": ("dop85",)}, "There is no method 'dop85'; nearest: dop853"),
        ("swing", {"methods": ()}, "There is no method to try"),
        ("swing", {"formulations": ("polar",)}, "There is no formulation 'polar'"),
        ("swing", {"rtols": (1e-14,)}, "rtol is 1e-14"),
        ("swing", {"points": 1}, "points is 1"),
        ("swing", {"limit": 0.0}, "limit is 0"),
        ("swing", {"steps": 0}, "steps is 0"),
        ("swing", {"parameters": {"zz": 1.0}}, "There is no parameter 'zz'"),
        ("swong", {}, "no scene 'swong'; did you mean 'swing'"),
        ("driven", {}, "drivers leave no freedom, so nothing is integrated"),
        ("drawn", {}, "there is nothing to integrate"),
    ],
)
def test_wrong_input_is_refused(
    scene: str,
    options: dict[str, Any],
    message: str,
    rig: str,
    folder: Path,
    few: dict[str, Any],
) -> None:
    with pytest.raises(InputError) as caught:
        accuracy(rig, scene, folder=folder, **{**few, **options})
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("t,body.x\n0,0.5\n1,0.2\n2,0.1\n", {"quantities": ("body.vx",)}, "no column body.vx"),
        ("time,body.x\n1,0.2\n2,0.1\n", {}, "there is no column t; it has time, body.x"),
        ("t,body.xx\n1,0.2\n2,0.1\n", {}, "There is no series 'body.xx'; nearest: body.x"),
        ("t,body.x\n1,0.2\n2,oops\n", {}, "the 2. line of numbers is 2, oops"),
        ("t,body.x\n1,0.2\n2\n", {}, "the 2. line of numbers is 2"),
        ("t,body.x\n2,0.2\n1,0.1\n", {}, "each later than the one before"),
        ("t,body.x\n1,0.2\n2,0.1\n", {"t_end": 3.0}, "it ends at t = 2 s, before 3 s"),
        ("t\n1\n2\n", {}, "there is no column beside t"),
        ("", {}, "there is no column t"),
    ],
)
def test_unusable_reference_files_are_refused(
    text: str,
    options: dict[str, Any],
    message: str,
    rig: str,
    folder: Path,
    few: dict[str, Any],
    tmp_path: Path,
) -> None:
    path = tmp_path / "reference.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        accuracy(
            rig, "swing", folder=folder, **{**few, "t_end": None, "reference": path, **options}
        )
    assert message in str(caught.value)
    with pytest.raises(InputError, match=r"nowhere\.csv: cannot be read"):
        accuracy(rig, "swing", folder=folder, reference=tmp_path / "nowhere.csv")
