"""The command `linkwright check`: what a sound declaration amounts to, a paragraph a scene."""

from typing import TYPE_CHECKING

from codegen.emit.line_wrapping import quantity
from linkwright.cli.output import console, escaped, print_rows

if TYPE_CHECKING:
    from codegen.check.assembly import Assembly
    from codegen.explain.declaration_report import DeclarationReport, SceneFacts

_MOVED = 3  # layout: coordinates that are listed
_SINGULAR = {"bodies": "body", "parameters": "parameter"}


def show(report: "DeclarationReport", model: str) -> None:
    """Print the facts of the sound scenes, and what no scene uses."""
    for scene in report.scenes:
        if scene.assembly.problem:
            continue
        console().print(
            f"[bold]{escaped(report.model)}[/], scene [bold]{escaped(scene.name)}[/]: sound"
        )
        print_rows(rows(scene))
    for kind, names in report.unused.items():
        word = kind if len(names) > 1 else _SINGULAR.get(kind, kind.removesuffix("s"))
        console().print(f"No scene uses {word} {escaped(', '.join(names))}.")
    if not report.problems and report.scenes:
        console().print(f"Next: linkwright {escaped(next_command(report.scenes[0], model))}")


def rows(scene: "SceneFacts") -> list[tuple[str, str]]:
    """Titles and texts of a scene."""
    numbers = {
        "coordinate": scene.coordinates,
        "constraint": scene.constraints,
        "degree of freedom": scene.degrees_of_freedom,
    }
    counts = ", ".join(quantity(count, noun) for noun, count in numbers.items())
    found = [
        ("bodies", ", ".join(scene.bodies)),
        ("equations", f"{counts}; {'some redundant' if scene.notes else 'none redundant'}"),
        ("assembly", _assembly(scene.assembly, scene.constraints)),
    ]
    if scene.one_joint and scene.degrees_of_freedom:
        ends = ", ".join(f"{body} ({joint})" for body, joint in scene.one_joint)
        found.append(("one joint", ends))
    left_out = [", ".join(name for name, _ in scene.left_out)] if scene.left_out else []
    if scene.unused:
        word = "parameter" if len(scene.unused) == 1 else "parameters"
        left_out.append(f"{word} {', '.join(scene.unused)}")
    if left_out:
        found.append(("left out", "; ".join(left_out)))
    return [*found, *(("note", note) for note in scene.notes)]


def _assembly(assembly: "Assembly", constraints: int) -> str:
    """`the joints close, within 2e-16, and move 3 coordinates: rod.x 0.15 → 0.145 m`."""
    if not constraints:
        return "there are no joints to close"
    text = f"the joints close at t = 0, within {assembly.gap:.1e} m or rad"
    if not assembly.moved:
        return f"{text}, where the scene puts the bodies"
    moved = ", ".join(
        f"{one.name} {one.guess:.4g} → {one.reached:.4g} {one.unit}"
        for one in assembly.moved[:_MOVED]
    )
    more = len(assembly.moved) - _MOVED
    return (
        f"{text}; this moves {quantity(len(assembly.moved), 'coordinate')}: {moved}"
        f"{f', and {more} more' if more > 0 else ''}"
    )


def next_command(scene: "SceneFacts", model: str) -> str:
    """The command that fits a scene."""
    if scene.analysis == "equilibrium":
        return f"equilibrium {model} --scene {scene.name}"
    command = "simulate"
    if scene.analysis == "kinematics":
        command = "kinematics"
    elif scene.drivers and not scene.degrees_of_freedom:
        command = "inverse"
    return f"{command} {model} --scene {scene.name} --t-end 1"
