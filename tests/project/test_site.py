"""What the site promises, as far as its sources show it; `make docs` builds and executes it."""

import inspect
import re
import runpy
import sys
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

import linkwright
from codegen.files.generated_modules import companion_path
from codegen.generated_files.companions import COMPANIONS
from codegen.model.space_model import REFUSED, SpaceModel
from models.__main__ import machines

ROOT = Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"
API = DOCS / "reference" / "api"
DIRECTIVE = re.compile(r"^\.\. (?:auto\w+|py:data):: ([\w.]+)(?:\n {9,}(\w+))?", re.MULTILINE)


def documented() -> set[str]:
    """The names that the pages of the Python interface document."""
    text = ["\n".join(page.read_text(encoding="utf-8") for page in sorted(API.glob("*.md")))]
    runpy.run_path(str(DOCS / "_extensions" / "docstrings.py"))["list_methods"](None, "", text)
    return {name for names in DIRECTIVE.findall(text[0]) for name in names if name}


def test_every_public_name_is_documented() -> None:
    written = documented() | {"t", "__version__"}  # a sentence each, in declarations.md
    assert not set(linkwright.__all__) - written


# what methods return, of which users need the attributes and not the name
RETURNED = {
    "AssemblyModes": "runtime.assembly.assembly_modes",
    "MotionLimits": "runtime.continuation.motion_limits",
}


def test_every_documented_name_is_there() -> None:
    for name in documented():
        home = RETURNED.get(name.partition(".")[0])
        value: object = linkwright if home is None else import_module(home)
        for part in name.split("."):
            value = getattr(value, part)


def test_words_of_space_are_documented_and_refused_ones_are_not() -> None:
    listed = {name.partition(".")[2] for name in documented() if name.startswith("SpaceModel.")}
    assert {"body", "spherical", "universal", "weld", "gravity", "torque"} <= listed
    assert not {*REFUSED, "unit_of"} & listed


def test_every_way_to_declare_something_is_documented() -> None:
    """What a method of `Model` returns to the compiler alone is listed here, by name."""
    internal = {
        *("acting", "altered", "choice", "defaults", "effects_alone", "elements", "in_space"),
        *(
            "kind",
            "labels",
            "misfits",
            "place_of",
            "points",
            "problems",
            "recompose",
            "reconnected",
            "symbols",
        ),
        *("together", "varied", "unit_of", "watched"),
    }
    methods = {name for name in dir(linkwright.Model) if not name.startswith("_")}
    listed = {name.removeprefix("Model.") for name in documented() if name.startswith("Model.")}
    assert methods - listed == internal & methods
    offered = methods - {*linkwright.Model._unlisted}
    assert offered - listed == {"points", "problems"}  # tables, which messages may name


@pytest.mark.parametrize("machine", machines())
def test_every_machine_has_a_page(machine: str) -> None:
    script = DOCS / "gallery" / "machines" / f"plot_{Path(machine).name}.py"
    assert f'lw.load("{machine}"' in script.read_text(encoding="utf-8")


def test_every_machine_is_in_a_group_of_the_gallery() -> None:
    text = (DOCS / "gallery" / "index.md").read_text(encoding="utf-8")
    shown = [name for group in re.findall(r"```\{moving\} (.*)", text) for name in group.split()]
    scripts = (DOCS / "gallery" / "machines").glob("plot_*.py")
    assert sorted(shown) == sorted(path.stem.removeprefix("plot_") for path in scripts)


def test_the_page_of_words_has_what_people_type_and_calls_that_are_there() -> None:
    text = (DOCS / "reference" / "words.md").read_text(encoding="utf-8")
    words = {word for row in re.findall(r"^\| (.*?) \|", text, re.M) for word in row.split(", ")}
    typed = {"hydraulic cylinder", "Stephenson", "torque-speed curve", "optimise", "spring", "cam"}
    typed |= {"ball joint", "rod end", "tie rod", "bevel gear", "differential", "RSSR"}
    typed |= {"torque between two bodies", "viscous friction"}
    typed |= {"gear ratio", "four-bar", "damper", "hinge", "pin", "slider", "motor", "limit stop"}
    assert not (typed | {"dead centre", "animation", "unit", "CSV", "Excel"}) - words
    for found in re.finditer(r"`(model|m|r)\.(\w+)(?:\(([^`…]*)\))?", text):
        (owner, name, given), row = found.groups(default=""), found.start()
        cls = {"model": linkwright.Model, "m": linkwright.Machine, "r": linkwright.Result}[owner]
        in_space = owner == "model" and row > text.index("## Machines in space")
        function = getattr(SpaceModel if in_space else cls, name)
        for keyword in re.findall(r"(\w+)=", given):
            assert keyword in inspect.signature(function).parameters, (name, keyword)


def test_a_machine_in_motion_is_a_picture_in_xml(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(DOCS / "_extensions")
    import moving_pictures

    monkeypatch.setattr(moving_pictures, "MOVING", tmp_path)
    run = linkwright.load("four_bar", scene="kinematics").kinematics(1.0)
    moving_pictures.save("four_bar", run)
    files = (tmp_path / f"four_bar{ending}.svg" for ending in ("", "-still"))
    moving, still = map(ElementTree.parse, files)
    turns = moving.findall(".//*[@type='rotate']")
    assert turns
    frames = moving_pictures.FRAMES
    assert all(len(turn.attrib["values"].split(";")) == frames for turn in turns)
    ends = [[float(value) for value in turn.attrib["values"].split(";")][::120] for turn in turns]
    assert max(abs(last - first) for first, last in ends) == pytest.approx(360, abs=0.02)  # crank
    assert not still.findall(".//*[@attributeName]")
    paths = [len(tree.findall(".//{*}path")) for tree in (still, moving)]
    assert paths[0] == paths[1] > 5


def test_a_machine_in_space_moves_by_one_picture_after_the_other(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(DOCS / "_extensions")
    import moving_pictures

    monkeypatch.setattr(moving_pictures, "MOVING", tmp_path)
    run = linkwright.load("space/stewart_platform", scene="legs").kinematics(1.0)
    moving_pictures.save("stewart_platform", run)
    files = (tmp_path / f"stewart_platform{ending}.svg" for ending in ("", "-still"))
    moving, still = map(ElementTree.parse, files)
    groups = moving.findall("{*}g")
    assert len(groups) == moving_pictures.FRAMES_IN_SPACE
    assert [one.attrib["display"] for one in groups] == ["inline"] + ["none"] * (len(groups) - 1)
    paths = [[path.attrib["d"] for path in one.findall("{*}path")] for one in groups]
    assert [path.attrib["d"] for path in still.findall(".//{*}path")] == paths[0]
    assert paths[0] != paths[1]
    assert not still.findall(".//*[@attributeName]")


def test_tables_of_commands_are_the_output_of_cells() -> None:
    """Frames of the terminal stand on no page: `make docs` executes the commands."""
    pages = [page for page in sorted(DOCS.rglob("*.md")) if "_build" not in page.parts]
    assert len(pages) > 50
    assert not [page.name for page in pages if re.search("[┏╇]", page.read_text("utf-8"))]


def test_figures_are_made_by_the_build() -> None:
    """The pages show no image file but what their cells write."""
    shown = re.compile(r"!\[[^\]]*\]\(|```\{(?:figure|image)\}|<img ")
    for page in sorted(DOCS.rglob("*.md")):
        if not {"_build", "notebooks", "pages"} & set(page.relative_to(DOCS).parts):
            assert not shown.search(page.read_text("utf-8")), page.name
    kept = [path for path in DOCS.rglob("*.png") if not {"_build", "pages"} & set(path.parts)]
    assert not [path for path in kept if "notebooks" not in path.parts]


def test_what_pages_build_does_not_make_them_run_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", list(sys.path))
    is_companion = runpy.run_path(str(DOCS / "conf.py"))["is_companion"]
    module = ROOT / "generated" / "four_bar__kinematics.py"
    assert not is_companion(module)
    assert not is_companion(ROOT / "generated" / "methods" / "dopri5.py")
    assert COMPANIONS
    assert all(is_companion(companion_path(module, kind.name)) for kind in COMPANIONS)


def test_a_notebook_without_a_picture_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sphinx")
    from docutils import nodes
    from docutils.frontend import get_default_settings
    from docutils.parsers.rst import Parser
    from docutils.utils import new_document

    monkeypatch.syspath_prepend(DOCS / "_extensions")
    from notebook_pictures import shows_a_picture

    page = new_document("page", get_default_settings(Parser))
    page += nodes.image(uri="../logo.svg")
    assert not shows_a_picture(page)
    page += nodes.container("", nodes.image(uri="_build/jupyter_execute/0123.png"))
    assert shows_a_picture(page)
