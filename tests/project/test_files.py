"""The project's files speak of the project alone, and those that every project owes are there."""

import re
from pathlib import Path

import pytest

# An absolute path below somebody's home or working folder; not part of an address or relative path.
LOCAL_PATH = re.compile(r"(?<![\w.~*/-])/(?:home|root|Users|work|tmp)/|\b[A-Z]:\\Users\\")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("open('/" + "home/anna/model.py')", True),
        ("see /" + "tmp/out.nc", True),
        (r"C:\Us" + r"ers\anna", True),
        ("https://example.org/home/page", False),
        ("docs/work/plan.md", False),
    ],
)
def test_the_search_for_local_paths_finds_them(text: str, found: bool) -> None:
    assert bool(LOCAL_PATH.search(text)) is found


def test_no_file_names_a_path_of_one_machine(root: Path, project_files: tuple[Path, ...]) -> None:
    offences = []
    for path in project_files:
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:  # a picture or a table in binary form
            continue
        offences += [
            f"{path.relative_to(root)}:{number}: {line.strip()}"
            for number, line in enumerate(text.splitlines(), 1)
            if LOCAL_PATH.search(line)
        ]
    assert not offences, "\n".join(offences)


@pytest.mark.parametrize("name", ["LICENSE", "README.md", "CHANGELOG.md", "docs/architecture.md"])
def test_the_file_is_there_and_says_something(root: Path, name: str) -> None:
    assert len((root / name).read_text(encoding="utf-8").split()) > 10


def test_licence_names_its_owner(root: Path) -> None:
    text = (root / "LICENSE").read_text(encoding="utf-8")
    assert text.startswith("BSD 3-Clause License")
    assert "Copyright (c) 2026, The Linkwright authors" in text


def test_python_files_stay_short(root: Path, project_files: tuple[Path, ...]) -> None:
    lengths = {
        path.relative_to(root).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in project_files
        if path.suffix == ".py" and path.parent != root / "generated"
    }
    assert len(lengths) > 10
    assert not {name: length for name, length in lengths.items() if length > 400}
