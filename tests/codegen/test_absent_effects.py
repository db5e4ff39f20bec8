"""An effect that a scene leaves out costs no operation, parameter, state, event or byte."""

import re
from collections.abc import Collection, Iterator
from copy import copy
from dataclasses import replace
from pathlib import Path

import pytest

from codegen import Model
from codegen.declare.scene import Scene
from codegen.derive.equations import derive
from codegen.emit.module import Origin, module_text
from codegen.explain.operations_by_part import marginal_operations
from codegen.lower.lowered_scene import Lowered, lower
from codegen.lower.operation_count import operations
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes
from models.hard.roller_chain import roller_chain

NAMES = ("MODEL", "SCENE", "LEFT_OUT", "UNUSED")
"""Tables of the header that list names of what is not there."""


def library(root: Path) -> list[Path]:
    found = sorted(root.glob("models/[!_]*.py")) + sorted(root.glob("models/hard/[!_]*.py"))
    return [path for path in found if "\nmodel = " in path.read_text(encoding="utf-8")]


def small_model(path: Path) -> Model:
    """The model of a file; of the chain of thirty rollers one of ten, which has all its kinds."""
    return roller_chain(10) if path.stem == "roller_chain" else read_model(path).model


def compiled_without_names(model: Model, scene: Scene) -> tuple[str, Lowered]:
    """A scene's text, but for the names in its header."""
    lowered = lower(derive(model, scene))
    text = module_text(lowered, Origin("linkwright", (), "0" * 64, "build"))
    lines = [line for line in text.splitlines() if not line.startswith(("# content", '"""Mach'))]
    text = "\n".join(lines)
    for name in NAMES:
        text = re.sub(rf"^{name} = (?:\(\n(?:    .*\n)*\)|.*)\n", "", text, flags=re.MULTILINE)
    return text, lowered


def counts(lowered: Lowered) -> dict[str, int]:
    return {k.name: operations(lowered.program, k) for k in lowered.program.kernels}


def never_declared(model: Model, *effects: str) -> Model:
    """The model as it would be if these effects were not in its file."""
    other = model.altered(
        effects={n: e for n, e in model.effects.items() if n not in effects},
        fidelities={n: f for n, f in model.fidelities.items() if n not in effects},
        groups={
            group: {c: tuple(n for n in names if n not in effects) for c, names in choices.items()}
            for group, choices in model.groups.items()
        },
    )
    return without_values(other, effects)


def without_values(model: Model, gone: Collection[str]) -> Model:
    """Forget the symbols of the values that elements were declared with."""
    model._read = copy(model._read)
    model._read.symbols = [
        (where, symbols)
        for where, symbols in model.symbols
        if not any(f"'{name}'" in where for name in gone)
    ]
    return model


def with_and_without(path: Path) -> Iterator[tuple[Model, Lowered, str, Scene]]:
    """Each scene with all its effects, lowered, and without one of them."""
    model = small_model(path)
    for scene in valid_scenes(model, None):
        whole = lower(derive(model, scene))
        for effect in unlike(model, scene.effects):
            (bare,) = valid_scenes(model, scene.without(effect))
            yield model, whole, effect, bare


def unlike(model: Model, effects: tuple[str, ...]) -> tuple[str, ...]:
    """All effects; of a long row of equals, those at its ends, beside them and in the middle."""
    rows: dict[object, list[str]] = {}
    for name in effects:
        rows.setdefault(declared(model, name), []).append(name)
    dropped = {
        name
        for row in rows.values()
        if len(row) > 12
        for name in set(row) - {*row[:2], row[len(row) // 2], *row[-2:]}
    }
    return tuple(name for name in effects if name not in dropped)


def declared(model: Model, name: str) -> object:
    """What an effect declares, but for its name and those of the bodies that it acts between."""
    if name not in model.effects:
        return name
    effect = model.effects[name]
    values = repr({key: value for key, value in vars(effect).items() if key != "name"})
    bodies = "|".join(sorted(map(re.escape, model.bodies), key=len, reverse=True))
    return type(effect), re.sub(rf"(?<![a-z])({bodies})(?![0-9])", "body", values)


MACHINES = [path.stem for path in library(Path(__file__).resolve().parents[2])]


@pytest.mark.parametrize("machine", MACHINES)
def test_every_effect_leaves_no_trace(machine: str, root: Path) -> None:
    (path,) = (p for p in library(root) if p.stem == machine)
    for model, whole, effect, bare in with_and_without(path):
        where = f"{bare.name}, {effect}"
        text, without = compiled_without_names(model, bare)
        never, _ = compiled_without_names(never_declared(model, effect), bare)
        assert text == never, where
        told = without.description
        assert effect not in {name for name, *_ in (*told.switches, *told.reactions, *told.powers)}
        full, rest = counts(whole), counts(without)
        difference = {name: count - rest.get(name, 0) for name, count in full.items()}
        assert difference == marginal_operations(whole, effect), where
        assert set(rest) <= set(full), where


def test_effects_cost_what_they_should(root: Path) -> None:
    # A constant torque on one body is one product in its power, and one sum in the solution.
    model = read_model(root / "models" / "quick_return.py").model
    own = marginal_operations(lower(derive(model, model.scenes["shaper"])), "motor")
    assert {k: n for k, n in own.items() if n} == {"accelerations": 1, "powers": 1}
    # A friction that sticks costs the closure of the loads, and no applied force.
    model = read_model(root / "models" / "hard" / "guide_friction.py").model
    own = marginal_operations(lower(derive(model, model.scenes["rocking"])), "rub")
    assert own["accelerations"] > 100
    assert own["applied_forces"] == 0


def bare_compressor(root: Path) -> tuple[Model, Scene]:
    model = read_model(root / "models" / "slider_crank.py").model
    return model, model.scene("compressor").without("gas", "motor").with_(outputs=[])


def test_compressor_of_gravity_alone_is_that_of_a_machine_with_nothing_else(root: Path) -> None:
    model, scene = bare_compressor(root)
    assert scene.effects == ("gravity_right",)
    text, lowered = compiled_without_names(model, scene)
    poor = never_declared(model, *(set(model.effects) - {"gravity_right"}))
    without_values(poor, poor.drivers)
    left = {n: p for n, p in model.parameters.items() if n in ("J1", "rod_length")}
    poor = poor.altered(drivers={}, scenes={}, parameters=left)
    given = {"start": dict(scene.start), "guess": dict(scene.guess), "outputs": []}
    poor.scene("falling", ["gravity_right"], **given)
    other, _ = compiled_without_names(poor, valid_scenes(poor, "falling")[0])
    assert text == other
    kernels = {k.name for k in lowered.program.kernels}
    assert not kernels & {"reactions", "powers", "kinetic_energy", "potential", "switching"}


def test_parameters_of_what_is_left_out_are_gone(root: Path) -> None:
    model, scene = bare_compressor(root)
    told = lower(derive(model, scene)).description
    assert [name for name, *_ in told.parameters] == ["J1", "rod_length"]
    assert told.unused == ("motor_torque", "drive_speed", "gas_scale")


def test_multipliers_that_nothing_asks_for_are_not_recovered(root: Path) -> None:
    model = read_model(root / "models" / "slider_crank.py").model
    whole = model.scene("compressor")
    counted = {}
    for outputs in ("all", ["energy"], ["reaction(guide)"]):
        lowered = lower(derive(model, whole.with_(outputs=outputs)))
        stored = {
            out.slot
            for k in lowered.program.kernels
            if k.name == "accelerations"
            for out in k.outputs
            if out.array == "lam"
        }
        assert stored == set(lowered.description.recovered)
        counted[str(outputs)] = counts(lowered)["accelerations"], len(stored)
    assert counted["['energy']"][1] == 0
    assert counted["['reaction(guide)']"][1] == 2
    assert counted["['energy']"][0] < counted["['reaction(guide)']"][0] < counted["all"][0]


def test_kinematic_scene_of_the_quick_return_is_small(root: Path) -> None:
    model = read_model(root / "models" / "quick_return.py").model
    moving = counts(lower(derive(model, model.scenes["kinematics"])))
    shaping = counts(lower(derive(model, model.scenes["shaper"])))
    assert sum(moving.values()) <= 375
    assert sum(moving.values()) < 0.5 * sum(shaping.values())
    for kernel in ("accelerations", "correction"):  # the cost of every instant
        assert moving[kernel] < 0.5 * shaping[kernel]
    assert not set(moving) & {"mass", "applied_forces", "potential", "powers", "reactions"}


def test_scene_for_equilibrium_knows_no_motion(root: Path) -> None:
    model = read_model(root / "models" / "slider_crank.py").model
    rest = model.scene("gas_equilibrium").with_(analysis="equilibrium")
    kernels = {k.name: k for k in lower(derive(model, rest)).program.kernels}
    absent = {"acceleration_rhs", "correction", "kinetic_energy", "powers", "switching_rates"}
    assert not set(kernels) & absent
    silent = lower(derive(model, rest.with_(outputs=["energy"]))).program.kernels
    assert not {k.name for k in silent} & {"accelerations", "reactions"}


def test_scene_of_the_spring_alone_has_no_events(root: Path) -> None:
    path = root / "models" / "coil_spring.py"
    model = read_model(path).model
    lowered = lower(derive(model, model.scenes["surge"]))
    assert lowered.description.switches == ()
    assert not {k.name for k in lowered.program.kernels} & {"switching", "switching_rates", "holds"}


def test_frozen_parameters_fold_and_others_stay(root: Path) -> None:
    model = read_model(root / "models" / "hard" / "guide_friction.py").model
    scene = model.scene("rocking").with_(parameters={"torque": 0.0})
    free, fixed = (lower(derive(model, s)) for s in (scene, scene.with_(frozen=True)))
    assert "torque" in {name for name, *_ in free.description.parameters}
    assert fixed.description.parameters == ()
    assert counts(fixed)["applied_forces"] < counts(free)["applied_forces"]


def test_names_of_on_the_fly_scenes_do_not_reach_the_kernels(root: Path) -> None:
    model = read_model(root / "models" / "slider_crank.py").model
    scene = model.scene("compressor").without("gas")
    one, _ = compiled_without_names(model, scene)
    other, _ = compiled_without_names(model, replace(scene, name="idling"))
    assert one == other
