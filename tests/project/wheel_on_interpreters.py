"""Builds the wheel and uses it on other interpreters, in new environments, from other folders.

    python -m tests.project.wheel_on_interpreters python3.12 /path/to/python3.13

On each: the locked versions are installed with the wheel, the command builds a model, a process
simulates it and saves the result in every format, a second one reads it back with the same bits,
and the command writes a report. The runtime compiles once, some minutes each. It prints a line for
each interpreter, with the processor times of importing and of a first result; the exit status is 1
where one fails.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
MODEL = """
from linkwright import Model

model = Model("pendulum", gravity=(0, -9.81))
length = model.parameter("length", 1.0, unit="m", sign="positive")
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
model.torque("damper", on=bob, value=-0.3 * bob.omega)
model.scene("swing", effects=["gravity", "damper"], start={bob.phi: 0.0, bob.omega: 0.0})
"""
CASE = "model: pendulum.py\nparameters: {length: 120 cm}\nrun: {t_end: 2, rtol: 1e-9}\n"
SAVE = """
import linkwright as lw
r = lw.load_case("long.yaml").analyse()
for ending in ("nc", "zarr", "csv", "parquet", "mat", "html"):
    r.save(f"run.{ending}")
"""
READ = """
import linkwright as lw
r = lw.load_case("long.yaml").analyse()
for ending in ("nc", "zarr"):
    found = lw.load_result(f"run.{ending}")
    assert (found.q("bob.phi") == r.q("bob.phi")).all()
    assert (found.at(0.123).q("bob.phi") == r.at(0.123).q("bob.phi")).all()
print(r.q("bob.phi")[-1].hex())
"""


def main() -> int:
    """Try each interpreter; the exit status."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = _wheel(folder)
        worked = [_works(python, wheel, folder) for python in sys.argv[1:]]  # all are tried
        return int(not all(worked))


def _wheel(folder: Path) -> Path:
    build = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
    return folder / _run(sys.executable, "-c", build, folder, at=ROOT).splitlines()[-1]


def _works(interpreter: str, wheel: Path, folder: Path) -> bool:
    place = folder / interpreter.replace(os.sep, "_")
    work = place / "work"
    try:
        _run(interpreter, "-m", "venv", place / "env", at=folder)
        programs = place / "env" / "bin"
        python, command = programs / "python", programs / "linkwright"
        locked = ("--constraint", ROOT / "constraints.txt", f"{wheel}[files,animation]")
        _run(python, "-m", "pip", "install", "--quiet", *locked, at=folder)
        work.mkdir()
        (work / "pendulum.py").write_text(MODEL)
        (work / "long.yaml").write_text(CASE)
        _run(command, "build", "pendulum.py", at=work)
        _run(python, "-W", "error", "-c", SAVE, at=work)
        last, result = _timed(python, "-W", "error", "-c", READ, at=work)
        _run(command, "report", "long.yaml", "--out", "long.html", at=work)
        _, imported = _timed(python, "-c", "import linkwright", at=work)
        version = _run(python, "--version", at=work).strip()
    except subprocess.CalledProcessError as error:
        sys.stdout.write(f"{interpreter}: {error}\n{error.stdout}\n{error.stderr}\n")
        return False
    sys.stdout.write(
        f"{version}: import {imported:.3f} s, first result {result:.2f} s of processor time; "
        f"bob.phi = {last.strip()}\n"
    )
    return True


def _run(*words: object, at: Path) -> str:
    done = subprocess.run(
        [str(word) for word in words], cwd=at, capture_output=True, text=True, check=True
    )
    return done.stdout


def _timed(*words: object, at: Path) -> tuple[str, float]:
    """Output and processor time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = _run(*words, at=at)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return out, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    sys.exit(main())
