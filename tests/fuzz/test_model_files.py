"""Faulty model files are refused in sentences."""

from pathlib import Path
from random import Random

from codegen.reading.model_file import read_model
from tests.fuzz import model_files


def test_the_sound_file_is_sound(tmp_path: Path) -> None:
    file = tmp_path / "sound.py"
    file.write_text(model_files.SOUND)
    scenes = model_files.valid_scenes(read_model(str(file)).model, None)
    assert [scene.name for scene in scenes] == ["swing", "driven"]


def test_faulty_files_are_refused_in_sentences(tmp_path: Path) -> None:
    for name, text in model_files.ODD_FILES.items():
        assert model_files.written(tmp_path, name, text) == "", name
    judged = (model_files.judge(Random(f"model_files 3 {number}")) for number in range(150))
    assert list(filter(None, judged)) == []
