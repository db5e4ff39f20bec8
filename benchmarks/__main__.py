"""``python -m benchmarks [kernels | compressor]...``: tables on the terminal, JSON in results/."""

import json
import platform
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from benchmarks import compressor, kernels

RESULTS = Path(__file__).resolve().parent / "results"
LIBRARIES = ("linkwright", "numba", "numpy", "scipy", "sympy")
NAMES = ("kernels", "compressor")
console = Console(width=110, highlight=False)


def versions() -> dict[str, str]:
    """What the numbers were measured with."""
    found = {"python": platform.python_version(), "processor": _processor()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "source tree"
    return found


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def save(name: str, rows: list[dict[str, Any]], folder: Path) -> Path:
    """The measurement as JSON."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"versions": versions(), "rows": rows}, indent=2) + "\n")
    return path


def show_kernels(quick: bool, folder: Path) -> None:
    """Generated kernels and their hand-written twins."""
    rows = kernels.measure(*((20_000, 3) if quick else (1_000_000, 15)))
    table = Table(title="slider-crank: generated kernels and hand-written twins")
    for heading in ("generated", "hand", "operations", "hand", "ns", "hand", "ratio", "difference"):
        table.add_column(heading, justify="left" if heading == "generated" else "right")
    for row in rows:
        table.add_row(
            row.generated,
            row.hand,
            str(row.operations),
            str(row.hand_operations),
            f"{row.nanoseconds:.1f}",
            f"{row.hand_nanoseconds:.1f}",
            f"{row.ratio:.2f}",
            f"{row.difference:.1e}",
        )
    console.print(table)
    ratio = rows[-1].ratio
    verdict = "holds" if ratio <= kernels.BAR else "is missed"
    console.print(
        f"all 9 accelerations and 8 multipliers take {ratio:.2f} times the hand-derived equation "
        f"of one degree of freedom; the bar of {kernels.BAR} {verdict}"
    )
    records = [{**asdict(row), "ratio": row.ratio} for row in rows]
    console.print(f"written: {save('kernels', records, folder)}")


def show_compressor(quick: bool, folder: Path) -> None:
    """One second of motion."""
    rows = compressor.measure(1 if quick else 5)
    table = Table(title="compressor, J = 450 kg m², 1 s")
    headings = ("method", "rtol", "ms", "times ours", "error of crank.phi, rad", "evaluations")
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "method" else "right")
    for row in rows:
        table.add_row(
            row.method,
            f"{row.rtol:.0e}",
            f"{row.milliseconds:.2f}",
            f"{row.milliseconds / rows[0].milliseconds:.1f}",
            f"{row.error:.1e}",
            str(row.evaluations),
        )
    console.print(table)
    records = [asdict(row) for row in rows]
    console.print(f"written: {save('compressor', records, folder)}")


def main(
    names: Annotated[list[str] | None, typer.Argument(help="kernels, compressor; both")] = None,
    quick: Annotated[bool, typer.Option(help="Fewer repeats; times are rough.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for the JSON files.")] = RESULTS,
) -> None:
    """Measure, print, and write down."""
    for name in names or NAMES:
        if name not in NAMES:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(NAMES)}")
    for name in names or NAMES:
        {"kernels": show_kernels, "compressor": show_compressor}[name](quick, out)


if __name__ == "__main__":
    typer.run(main)
