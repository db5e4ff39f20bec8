"""Tracked points: they take part where their paths are asked for, and exert nothing."""

from codegen.derive.equations import derive
from codegen.lower.lowered_scene import lower
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.test_scenes import sledge


def test_points_come_with_their_paths_and_go_with_their_bodies() -> None:
    model = sledge()
    slide = model.scene("slide")
    assert "nose" not in slide.effects
    assert slide.with_(outputs=["point(nose)"]).effects == ("spring", "rub", "nose")
    both = slide.with_(outputs=["points"])
    assert both.effects == ("spring", "rub", "nose", "hook")
    assert both.without("load").effects == ("spring", "rub", "nose")
    moved = slide.without("spring", "rub").with_(analysis="kinematics", outputs=["point(nose)"])
    equations = derive(model, valid_scenes(model, moved)[0])
    assert [e.name for e in equations.effects] == ["nose"]
    kernels = {k.name for k in lower(equations).program.kernels}
    assert "reactions" in kernels
    assert not kernels & {"mass", "applied_forces", "powers"}
