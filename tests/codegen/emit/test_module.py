"""The text of generated modules: valid, tidy, the same every time, and true to the program."""

import ast
import hashlib
import os
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

from codegen.emit.line_wrapping import wrap_pieces
from codegen.emit.module_functions import SIN_COS
from codegen.lower.operation_count import by_element, operations
from tests.codegen.workbench import Interpreted

Scenes = dict[str, Interpreted]
Texts = dict[str, str]
STEPS = r"    # (Sizes|Eliminate|Solve|Substitute|The matrix|W Φ|Refine|Friction)"
HASHES = """
from hashlib import sha256
from pathlib import Path
from codegen.reading.scene_selection import valid_scenes
from codegen.reading.model_file import read_model
from tests.codegen.machines import ODD
from tests.codegen.workbench import Interpreted
for model in (read_model(Path("models/slider_crank.py")).model, *(declare() for declare in ODD)):
    for scene in valid_scenes(model, None):
        text = Interpreted(model, scene.name).text()
        print(model.name, scene.name, sha256(text.encode()).hexdigest())
"""


def ruff(root: Path, *arguments: str, text: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "ruff", *arguments, "-"],
        input=text,
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )


def functions(text: str) -> dict[str, ast.FunctionDef]:
    """The kernels; what they call is tested for itself."""
    nodes = (node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef))
    return {node.name: node for node in nodes if node.name != SIN_COS}


def tables(text: str) -> dict[str, object]:
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            found[node.targets[0].id] = ast.literal_eval(node.value)
    return found


def test_there_is_enough_to_look_at(texts: Texts) -> None:
    assert len(texts) == 17


def test_text_is_as_the_formatter_leaves_it(root: Path, texts: Texts, tmp_path: Path) -> None:
    for name, text in texts.items():
        (tmp_path / f"{name.replace('.', '__')}.py").write_text(text)
    options = ("--isolated", "--line-length", "100", "--target-version", "py311")
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "format", "--diff", *options, str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[:3000]


def test_text_is_lint_clean(root: Path, texts: Texts) -> None:
    for name, text in texts.items():
        done = ruff(root, "check", "--stdin-filename", "generated/module.py", text=text)
        assert done.returncode == 0, f"{name}\n{done.stdout[:2000]}"


def test_lines_of_code_fit_the_page(texts: Texts) -> None:
    for name, text in texts.items():
        body = text[text.index("@numba.njit") :]
        long = [line for line in body.splitlines() if len(line.partition("  #")[0]) > 100]
        assert not long, f"{name}: {long[:3]}"


def test_text_does_not_depend_on_the_hash_seed(root: Path, texts: Texts) -> None:
    """In two processes with seeds of their own, and in this one with its own."""
    running = [
        subprocess.Popen(
            [sys.executable, "-c", HASHES],
            cwd=root,
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("0", "42")
    ]
    answers = [process.communicate(timeout=120)[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    hashes = [line.split()[-1] for line in answers[0].splitlines()]
    assert len(hashes) == 17
    assert answers[0] == answers[1]
    assert sorted(hashes) == sorted(hashlib.sha256(t.encode()).hexdigest() for t in texts.values())


def test_signature_is_the_hash_of_the_text(texts: Texts) -> None:
    for text in texts.values():
        (found,) = re.findall(r"^# content-sha256: ([0-9a-f]{64})$", text, re.MULTILINE)
        blank = text.replace(found, "0" * 64)
        assert hashlib.sha256(blank.encode()).hexdigest() == found


def test_operations_in_the_text_are_those_of_the_ledger(scenes: Scenes, texts: Texts) -> None:
    for name, machine in scenes.items():
        program = machine.program
        counts = {k.name: operations(program, k) for k in program.kernels}
        assert dict(tables(texts[name])["OPERATIONS"]) == counts
        for kernel, node in functions(texts[name]).items():
            (count,) = re.findall(r"^(\d+) operations?\.$", ast.get_docstring(node), re.MULTILINE)
            assert int(count) == counts[kernel]
        for kernel in program.kernels:
            assert sum(by_element(program, kernel).values()) == counts[kernel.name]


def counted(node: ast.AST) -> int:
    """Arithmetic that Python sees in a function: what it does is what the ledger says."""
    kinds = (ast.BinOp, ast.IfExp, ast.If)
    called = [n.func for n in ast.walk(node) if isinstance(n, ast.Call)]
    calls = len(called) + sum(isinstance(f, ast.Name) and f.id == SIN_COS for f in called)
    return calls + sum(isinstance(n, kinds) for n in ast.walk(node))


def test_text_does_no_more_than_the_ledger_says(scenes: Scenes, texts: Texts) -> None:
    for name, machine in scenes.items():
        for kernel in machine.program.kernels:
            node = functions(texts[name])[kernel.name]
            extra = 2 * len(kernel.checks) if kernel.watched else 0
            body = ast.Module([n for n in node.body if not isinstance(n, ast.Expr)], [])
            negations = sum(isinstance(n, ast.UnaryOp) for n in ast.walk(body))
            assert counted(body) <= operations(machine.program, kernel) + extra + negations


def test_every_output_is_stored_once(scenes: Scenes, texts: Texts) -> None:
    for name, machine in scenes.items():
        for kernel in machine.program.kernels:
            node = functions(texts[name])[kernel.name]
            stored = [
                (target.value.id, target.slice.value)
                for statement in ast.walk(node)
                if isinstance(statement, ast.Assign)
                for target in statement.targets
                if isinstance(target, ast.Subscript)
            ]
            expected = [(out.array, out.slot) for out in kernel.outputs if out.array != "return"]
            assert stored == expected, f"{name}, {kernel.name}"


def test_branches_ask_modes_only(texts: Texts) -> None:
    asked = 0
    for name, text in texts.items():
        for kernel, node in functions(text).items():
            allowed = {"modes"}
            for piece in ast.walk(node):
                if (
                    isinstance(piece, ast.Assign)
                    and isinstance(piece.value, ast.BoolOp | ast.UnaryOp | ast.Subscript)
                    and names_in(piece.value) <= allowed
                ):
                    allowed |= names_in(piece.targets[0])  # a mode, or a condition made of modes
            for branch in ast.walk(node):
                assert not isinstance(branch, ast.For | ast.While)
                if isinstance(branch, ast.If | ast.IfExp):
                    names = names_in(branch.test)
                    watch = "WEAK_PIVOT" in names
                    # The array itself is not read behind a branch: numba would count references.
                    fine = watch or names <= allowed - {"modes"}
                    assert fine, f"{name}, {kernel}: {ast.unparse(branch)}"
                    asked += not watch
    assert asked > 20


def names_in(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def test_kernels_take_what_the_contract_says(texts: Texts) -> None:
    text = texts["compressor"]
    expected = {
        "constants": "p",
        "constraints": "t q p phi",
        "jacobian": "t q p values",
        "velocity_rhs": "t q p nu",
        "acceleration_rhs": "t q v p gamma",
        "mass": "q p values",
        "applied_forces": "t q v p modes Q",
        "accelerations": "t q v p modes a lam",
        "correction": "t q v p w dq dv",
        "potential": "t q p modes",
        "potential_gradient": "t q p modes g",
        "kinetic_energy": "q v p",
        "powers": "t q v p modes lam out",
        "reactions": "t q v p lam out",
        "switching": "t q v p g",
        "switching_rates": "t q v a p rate",
    }
    taken = {n: " ".join(a.arg for a in f.args.args) for n, f in functions(text).items()}
    assert taken == expected
    kinematic = set(functions(texts["kinematics"]))
    masses = {"mass", "applied_forces", "potential", "potential_gradient", "kinetic_energy"}
    assert kinematic == set(expected) - masses - {
        "powers", "reactions", "switching", "switching_rates",
    }  # fmt: skip


def test_names_are_the_modellers(texts: Texts) -> None:
    text = texts["compressor"]
    for name in ("crank_phi = q[2]", "slider_vx = v[6]", "J1 = p[0]", "# gas", "# guide"):
        assert name in text
    assert "# crank_phi" in text  # beside the output
    assert "lam[3] = " in text
    assert "# B_y" in text


def test_tables_of_the_compressor(texts: Texts) -> None:
    found = tables(texts["compressor"])
    assert found["BODIES"] == ("crank", "rod", "slider")
    assert found["COORDINATES"][2] == ("crank.phi", "crank.omega", "rad")
    assert found["CONSTRAINTS"][0] == ("A", "revolute", "x")
    assert ("J1", 450.0, "kg m^2", "positive") in found["PARAMETERS"]
    assert found["EFFECTS"] == (("gas", "force"), ("motor", "torque"), ("gravity_right", "gravity"))
    assert ("crank_drive", "driver") in found["LEFT_OUT"]
    assert ("gas", "slider_vx > 0") in found["SWITCHES"]
    assert ("guide", "fy", "N") in found["REACTIONS"]
    assert found["POWERS"] == (("gas", "effect"), ("motor", "effect"))
    assert ("crank.omega", 30.0, "fixed") in found["START"]
    assert ("rod.omega", 17.142857, "guess") in found["START"]
    assert len(found["JACOBIAN_ROWS"]) == len(found["JACOBIAN_COLUMNS"])
    assert found["MASS_ROWS"] == found["MASS_COLUMNS"] == tuple(range(9))


def test_what_a_scene_leaves_out_costs_nothing(scenes: Scenes, texts: Texts) -> None:
    without, gas = texts["inverse_dynamics_without_gas"], texts["inverse_dynamics"]
    assert "gas" in functions(gas)["applied_forces"].body[0].value.value or "# gas" in gas
    assert "# gas" not in without
    assert scenes["inverse_dynamics_without_gas"].s == 0


def test_frozen_scene_offers_no_parameters(texts: Texts) -> None:
    found = tables(texts["folded.shut"])
    assert found["PARAMETERS"] == ()
    assert found["FOLDED"] == (("length", 1.25, "m", "positive"), ("mass", 4.0, "kg", "positive"))
    assert found["CONSTANTS"] == ()
    assert "p[" not in texts["folded.shut"].partition("def constraints")[2]
    assert "FOLDED" not in tables(texts["folded.open"])


def test_headings_stand_above_lines_of_their_own(texts: Texts) -> None:
    headings = 0
    for text in texts.values():
        lines = text.splitlines()
        for line, after in pairwise(lines):
            if not re.match(r"    # \S", line) or line == "    # Outputs":
                continue
            headings += 1
            if not re.match(STEPS, after):
                assert re.match(STEPS, line) or not re.match(r"    # ", after), (line, after)
            assert not re.search(rf"= {SIN_COS}\(\w+_phi\)", after), (line, after)
    assert headings > 100


def test_pieces_are_wrapped_as_they_are() -> None:
    """A piece holds together at its spaces, and keeps a no-break space."""
    pieces = [f"number\N{NO-BREAK SPACE}{k} of many," for k in range(10)]
    head, *lines, end = wrap_pieces("    call(", pieces, ")")
    assert (head, end) == ("    call(", "    )")
    assert " ".join(line.strip() for line in lines) == " ".join(pieces)
    assert len(lines) == 2
    assert all(line.startswith("        number") and len(line) <= 100 for line in lines)
