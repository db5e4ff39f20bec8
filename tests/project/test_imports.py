"""Who imports whom: in a fresh process, in the generated modules, and by rule."""

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def fresh(code: str, cwd: Path) -> str:
    """What a new interpreter prints, every warning being an error."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import runtime", {"sympy", "matplotlib", "netCDF4"}),
        ("from runtime import load", {"sympy", "matplotlib", "netCDF4"}),
        ("import linkwright", {"sympy", "numpy", "numba", "typing", "rich", "typer"}),
        ("from linkwright import load", {"sympy", "matplotlib", "netCDF4"}),
        ("import codegen.errors", {"sympy", "numba", "numpy", "runtime"}),
        ("from codegen import Model", {"numba", "runtime", "matplotlib", "scipy"}),
    ],
)
def test_an_import_loads_no_more_than_it_needs(
    root: Path, statement: str, absent: set[str]
) -> None:
    code = f"{statement}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    loaded = set(json.loads(fresh(code, root)))
    assert not loaded & absent


COMPILER = {
    *("codegen.readers", "codegen.readers.arguments", "codegen.errors"),
    *("codegen.files", "codegen.files.library_folders", "codegen.object_display"),
    *("codegen.readers.values", "codegen.readers.calls", "codegen.readers.quantities"),
    "codegen.presentation",
    *("codegen.garbage_collection", "codegen.parameter_conditions", "codegen.termination_signals"),
    *("codegen.files.build_records", "codegen.files.generated_modules"),
    "codegen.files.whole_files",
    *(
        "codegen.machine_code",
        "codegen.machine_code.code_folders",
        "codegen.machine_code.compiled_functions",
        "codegen.machine_code.expression_translation",
        "codegen.machine_code.file_lock",
        "codegen.machine_code.kernel_translation",
        "codegen.machine_code.kernels",
        "codegen.machine_code.separate_compilation",
        "codegen.machine_code.table_values",
        "codegen.machine_code.undocumented_names",
    ),
}

FIRST = """
from linkwright import load
run = load("slider_crank", scene="compressor").simulate(0.01)
import json, sys
print(json.dumps(sorted(sys.modules)))
"""


def test_a_first_result_loads_no_more_than_it_needs(root: Path) -> None:
    loaded = set(
        json.loads(fresh("import runtime, json, sys\nprint(json.dumps(sorted(sys.modules)))", root))
    )
    assert not loaded & {"numpy", "numba", "scipy", "rich", "typer"}
    fresh(FIRST, root)  # Compiles what is not in the caches yet.
    loaded = set(json.loads(fresh(FIRST, root)))
    assert not loaded & {"sympy", "pandas", "xarray", "matplotlib", "netCDF4", "rich", "typer"}
    # Numba looks for the routines of linear algebra in SciPy; nothing else is asked of it.
    listing = "import scipy.linalg, json, sys\nprint(json.dumps(sorted(sys.modules)))"
    asked = loaded - set(json.loads(fresh(listing, root)))
    rooms = {name.split(".")[1] for name in asked if name.startswith("scipy.")}
    assert not rooms & {"integrate", "interpolate", "optimize", "signal", "sparse", "stats"}
    assert not any(name.startswith("codegen.") for name in loaded - COMPILER)
    studies = ("runtime.studies", "runtime.accuracy_target")
    assert not any(name.startswith(studies) for name in loaded)


@pytest.mark.parametrize("first", ["import codegen", "import codegen.driver"])
def test_build_is_the_function_whatever_was_imported_first(root: Path, first: str) -> None:
    code = f"{first}\nfrom codegen import build\nprint(callable(build))"
    assert fresh(code, root).strip() == "True"


def test_generated_modules_import_numba_and_nothing_of_ours(root: Path) -> None:
    modules = [path for path in (root / "generated").glob("*.py") if path.name != "__init__.py"]
    assert modules
    for path in modules:
        imported = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, path.name
                imported.add((node.module or "").partition(".")[0])
        assert imported <= {"math", "numba", "numpy"}, path.name


def lint_imports(tree: Path) -> subprocess.CompletedProcess[str]:
    command = Path(sys.executable).with_name("lint-imports")
    return subprocess.run(
        [command, "--no-cache"], cwd=tree, capture_output=True, text=True, check=False
    )


FORBIDDEN = (
    ("codegen/driver.py", "import runtime", "runtime", "The compiler knows nothing"),
    ("codegen/declare/__init__.py", "import codegen.derive", "codegen.derive", "Data goes one way"),
    ("codegen/lower/__init__.py", "from codegen import emit", "codegen.emit", "Data goes one way"),
    (
        "codegen/lower/__init__.py",
        "from codegen import declare",
        "codegen.declare",
        "Lowering sees",
    ),
    ("codegen/emit/__init__.py", "import sympy", "sympy", "Emitting sees programs"),
    ("runtime/machine_loading.py", "def f():\n    import sympy", "sympy", "The runtime knows"),
    (
        "runtime/machine_loading.py",
        "from codegen import lower",
        "codegen.lower",
        "The runtime knows",
    ),
    (
        "runtime/integrate/__init__.py",
        "from runtime import machine_facade",
        "runtime.machine_facade",
        "Floors of the runtime",
    ),
    (
        "runtime/assembly/__init__.py",
        "from runtime import statics",
        "runtime.statics",
        "Floors of the runtime",
    ),
    ("runtime/integrate/__init__.py", "import xarray", "xarray", "The numerics know nothing"),
    ("models/example.py", "import codegen.elements", "codegen.elements", "A model is written"),
    ("models/example.py", "from runtime import load", "runtime", "Only the studies"),
    ("generated/example.py", "import scipy.linalg", "scipy", "A generated module stands"),
    ("models/example.py", "import linkwright", "linkwright", "The one name stands"),
)
ALLOWED = (
    ("runtime/machine_loading.py", "from codegen import build"),
    ("runtime/machine_loading.py", "from codegen.errors import InputError"),
    ("models/example.py", "from codegen import Model"),
    ("models/studies/compressor.py", "from runtime import load"),
    ("generated/example.py", "import math, numba, numpy"),
    ("runtime/results/series_lookup.py", "import runtime.dynamics.outputs_afterwards"),
)


@pytest.fixture
def skeleton(root: Path, tmp_path: Path) -> Path:
    """The project's modules with nothing in them but the allowed imports, and its import rules."""
    for package in ("codegen", "generated", "linkwright", "models", "runtime"):
        for path in (root / package).rglob("*.py"):
            copy = tmp_path / path.relative_to(root)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.touch()
    shutil.copy(root / ".importlinter", tmp_path)
    for module, statement in ALLOWED:
        append(tmp_path / module, statement)
    return tmp_path


def append(path: Path, statement: str) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(f"{statement}\n")


def test_allowed_imports_break_no_rule(skeleton: Path) -> None:
    done = lint_imports(skeleton)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_forbidden_import_is_found_under_its_rule(skeleton: Path) -> None:
    for module, statement, *_ in FORBIDDEN:
        append(skeleton / module, statement)
    done = lint_imports(skeleton)
    assert done.returncode == 1, done.stderr
    plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)  # older versions colour what they print
    verdicts, _, details = plain.partition("Broken contracts")
    broken = {line for line in verdicts.splitlines() if " BROKEN" in line}
    assert len(broken) == len({rule for *_, rule in FORBIDDEN})
    sections = re.split(r"\n(?=[^\n]+\n-+\n)", details)
    for module, _, target, rule in FORBIDDEN:
        (section,) = (text for text in sections if text.startswith(rule))
        importer = module.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        assert re.search(rf"{re.escape(importer)} -> {re.escape(target)}\b", section), section


@pytest.mark.parametrize(
    ("words", "absent"),
    [
        ("--version", {"numpy", "sympy", "numba", "rich", "filelock"}),
        ("--help", {"numpy", "sympy", "numba", "scipy", "pandas"}),
        ("simulate --help", {"numpy", "sympy", "numba", "scipy", "pandas"}),
    ],
)
def test_the_command_line_starts_with_little(root: Path, words: str, absent: set[str]) -> None:
    code = (
        f"import sys\nsys.argv = ['linkwright', *{words.split()}]\n"
        "from linkwright.command_line import main\ntry:\n    main()\n"
        "except SystemExit:\n    print('loaded', *sys.modules)"
    )
    *_, last = fresh(code, root).splitlines()
    assert last.startswith("loaded ")
    assert not set(last.split()) & absent
