"""The reference pages, their letters, and the command that lists and writes them."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from codegen import ModelError
from codegen.declare.element import Constraint
from codegen.declare.symbols import given
from codegen.derive.constraint_terms import constraint_terms
from codegen.elements.joints.weld import Weld
from codegen.elements.registry import kinds_of_elements
from codegen.latex import MEANINGS, WIDTH, Abbreviations, aligned, latex, lettered, symbol, width
from codegen.reference.pages import Pair, example_of, markdown, page, slug, write
from linkwright.cli.application import app
from tests.codegen.elements.drum import StringOnDrum, winch

LIBRARY = {name: kind for name, kind in kinds_of_elements().items() if not kind.is_user_defined}
CONSTRAINTS = [name for name, kind in LIBRARY.items() if kind.role != "force"]

FILE = """
from tests.codegen.elements.drum import winch

model = winch()
"""


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["elements", *map(str, arguments)])


# -- LaTeX -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_letters_and_short_names_change_no_value(kind: str) -> None:
    found = example_of(kind).element
    assert isinstance(found, Constraint)
    _, terms = constraint_terms(found)
    rows = [*terms.phi, *terms.nu, *terms.gamma, *(e for _, _, e in terms.reactions)]
    rows += [entry for row in terms.jacobian for entry in row]
    short = Abbreviations(rows)
    shown = [short(row) for row in rows]
    random = np.random.default_rng(1)
    symbols = sorted(set().union(*(row.free_symbols for row in rows)), key=lambda s: s.name)
    numbers = {latex(s): float(random.uniform(0.3, 2)) for s in symbols}
    for name, meaning in short.definitions():  # each before it is used in another
        numbers[name] = evaluated(meaning, numbers)
    for row, brief in zip(rows, shown, strict=True):
        assert_allclose(evaluated(brief, numbers), evaluated(row, numbers), rtol=1e-9, atol=1e-9)


def evaluated(expression: sympy.Expr, numbers: dict[str, float]) -> float:
    values = {s: numbers[latex(s)] for s in expression.free_symbols}
    tables = {"Interpolant": lambda table, order, at: table(at, order)}
    names = {atom: atom.table for atom in expression.atoms() if hasattr(atom, "table")}
    tables |= {str(atom): table for atom, table in names.items()}
    made = sympy.lambdify(list(values), expression, [tables, "math"])
    return float(made(*values.values()))


def test_letters_are_the_books() -> None:
    i_x, j_phi = (next(s for s in MEANINGS_SYMBOLS if s.name == n) for n in ("i_x", "j_phi"))
    assert symbol(i_x) == "x_{i}"
    assert symbol(j_phi.rate) == r"\dot \phi_{j}"
    _, terms = constraint_terms(example_of("revolute").element)  # type: ignore[arg-type]
    assert latex(lettered(terms.phi[0])) == "- d_{x}"
    assert latex(terms.multipliers[0]) == r"\lambda_{1}"


MEANINGS_SYMBOLS = set().union(*(meaning.free_symbols for meaning in MEANINGS.values()))


def test_abbreviations_have_a_letter_of_their_own() -> None:
    x, y, a = sympy.symbols("x y a")
    total = x + 2 * y - sympy.sin(x) + 10
    for factor, letter in ((x, "a"), (a, "b")):
        short = Abbreviations([factor * total, total**2])
        assert str(short(factor * total)) == str(factor * given(f"{letter}_1"))


def test_long_sums_are_broken_between_terms() -> None:
    terms = sympy.symbols("a_1:60")
    text = aligned([("V", sympy.Add(*terms))])
    lines = text.splitlines()[2:-2]
    assert len(lines) > 2
    assert all(width(line) <= WIDTH + 4 for line in lines)
    assert all(line.startswith(r"&\quad +") for line in lines[1:])


def test_docstrings_become_lists() -> None:
    text = markdown(
        """What it is.

        Parameters
        ----------
        i, j
            Two points.

        Notes
        -----
        Plain text.
        """
    )
    assert (
        text
        == "What it is.\n\n**Parameters**\n\n- `i`, `j`:\n  Two points.\n\n**Notes**\n\nPlain text."
    )


# -- pages -----------------------------------------------------------------------------------


def test_the_pages_are_what_the_library_gives(root: Path) -> None:
    done = write(root / "docs" / "elements", check=True)
    stale = [path.name for path in done.stale]
    assert not stale, "run: linkwright elements --out docs/elements"
    assert len(done.paths) == len(LIBRARY) + 2  # the index, and the page of those in space


@pytest.mark.parametrize("kind", LIBRARY)
def test_a_page_says_what_there_is_to_say(root: Path, kind: str) -> None:
    text = (root / "docs" / "elements" / f"{slug(kind)}.md").read_text(encoding="utf-8")
    headings = [line for line in text.splitlines() if line.startswith("#")]
    wanted = [f"# {kind.capitalize()}", "## Declaration", "## Equations"]
    wanted += ["## Reaction"] if LIBRARY[kind].role != "force" else []
    assert headings == [*wanted, "## Cost"]
    assert text.split("\n\n")[1] == LIBRARY[kind].summary
    assert not set("=≥²") & set(LIBRARY[kind].summary), "the first sentence is one in words"
    assert "_Dummy" not in text
    formulas = text.split("$$")[1::2]
    assert formulas
    for formula in formulas:
        assert formula.count("{") == formula.count("}")
        assert formula.count(r"\left") == formula.count(r"\right")
        assert "\n\n" not in formula
        assert "<" not in formula


def test_pages_are_the_same_whatever_the_hashes(root: Path) -> None:
    kinds = ("gear", "bushing", "contact", "point follower", "friction")
    code = (
        "from codegen.reference.pages import page\nimport hashlib\n"
        f"print(hashlib.sha256(''.join(map(page, {kinds})).encode()).hexdigest())"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            cwd=root,
            env={"PYTHONHASHSEED": seed, "PATH": ""},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed in ("1", "22")
    }
    assert len(found) == 1


def test_an_own_element_has_a_page() -> None:
    text = page(StringOnDrum.kind, winch())
    assert "model.add(StringOnDrum(name, drum, end, radius, length))" in text
    assert "The coordinate $\\alpha$ is the element's own; `radial` determines it." in text
    assert "| `jacobian` |" in text


def test_an_own_element_without_a_model_is_asked_for_one() -> None:
    with pytest.raises(ModelError, match="name a model file that declares one"):
        page(StringOnDrum.kind)


def test_a_kind_of_the_library_without_an_example_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(Weld, "example")
    with pytest.raises(ModelError, match="element 'weld' has no example; add one to Weld of"):
        page("weld")


def test_an_element_that_no_scene_takes_in_has_no_equations() -> None:
    pair = Pair("pair")
    pair.gravity("down", (0, -9.81))
    pair.gravity("up", (0, 9.81))
    pair.torque("motor", on=pair.i, value=1)
    pair.scene("falling", ["down"])
    assert "V_{y_{i}}" in page("gravity", pair)
    with pytest.raises(ModelError, match="no scene of model 'pair' has torque 'motor' in it"):
        page("torque", pair)


# -- the command -----------------------------------------------------------------------------


def test_the_command_lists_the_kinds() -> None:
    done = run()
    assert done.exit_code == 0
    for name, kind in LIBRARY.items():
        assert name in done.stdout
        assert kind.summary in done.stdout
    assert StringOnDrum.kind not in done.stdout


def test_the_command_shows_a_page_by_name_or_file(root: Path) -> None:
    text = (root / "docs" / "elements" / "rack-and-pinion.md").read_text(encoding="utf-8")
    assert run("rack-and-pinion").stdout == text
    for name in (("rack_and_pinion",), ("rack", "and", "pinion"), ("Rack and-pinion",)):
        assert run(*name).stdout == text
    assert run("torsion-spring").stdout == run("torsion spring").stdout


def test_the_command_hints_at_a_near_miss() -> None:
    done = run("revolut")
    assert done.exit_code == 2
    assert "there is no element 'revolut'; did you mean 'revolute'" in done.stderr


def test_the_command_lists_and_shows_elements_in_space(root: Path) -> None:
    plane, _, space = run().stdout.partition("In space")
    for kind in ("spherical", "universal", "cylindrical", "torsion spring in space"):
        assert f" {kind} " in space
        assert f" {kind} " not in plane
    title, shown = run("universal").stdout.split("\n", 1)
    assert title == "# Universal"
    assert "### universal\n" + shown in (root / "docs/elements/in-space.md").read_text("utf-8")


def test_the_command_shows_an_own_element(tmp_path: Path) -> None:
    file = tmp_path / "winch.py"
    file.write_text(FILE)
    listed = run("--model", file)
    assert "string on a drum" in listed.stdout
    shown = run("string-on-a-drum", "--model", file)
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.startswith("# String on a drum")


def test_check_finds_what_is_stale_missing_or_of_no_kind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {name: LIBRARY[name] for name in ("weld", "torque")}
    monkeypatch.setattr("codegen.reference.pages.kinds_of_elements", lambda **_: few)
    assert run("--out", tmp_path).exit_code == 0
    assert run("--out", tmp_path, "--check").exit_code == 0
    weld = tmp_path / "weld.md"
    before = weld.read_bytes()
    weld.write_text("something else")
    (tmp_path / "torque.md").unlink()
    (tmp_path / "belt.md").write_text("a kind of the past")
    done = run("--out", tmp_path, "--check")
    assert done.exit_code == 1
    for name in ("weld.md", "torque.md", "belt.md"):
        assert f"{name} is missing, out of date, or of no kind" in done.stderr
    assert weld.read_text() == "something else"
    run("--out", tmp_path)
    assert weld.read_bytes() == before


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = run("weld", "--out", tmp_path / "file" / "pages")
    assert done.exit_code == 2
    assert "cannot write" in done.stderr
