"""A sample of faulty model files; the campaign is `tests.fuzz.model_files`."""

from pathlib import Path

from codegen.reading.model_file import read_model
from tests.fuzz import campaign, model_files


def test_the_sound_file_is_sound(tmp_path: Path) -> None:
    file = tmp_path / "sound.py"
    file.write_text(model_files.SOUND)
    scenes = model_files.valid_scenes(read_model(str(file)).model, None)
    assert [scene.name for scene in scenes] == ["swing", "driven"]


def test_faulty_files_are_refused_in_sentences(tmp_path: Path) -> None:
    for name, text in model_files.ODD_FILES.items():
        assert model_files.written(tmp_path, name, text) == "", name
    campaigned = campaign.run("model_files", 3, range(150))
    assert campaigned.findings == [], campaigned.report()
