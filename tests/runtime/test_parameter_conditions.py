"""What the build asks of the defaults is asked of the parameters of each run, by one list."""

from collections.abc import Callable
from pathlib import Path

import pytest

from codegen.driver import build
from codegen.errors import ModelError, ParameterError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

MODEL = Path(__file__).with_name("conditioned.py")
BROKEN = {
    "turned": [
        ({"r1": 0.0}, [r"gear 'mesh': the radii \(r1, r2\) m contain a 0, 0 and 0\.3"]),
        ({"r1": -0.2}, [r"gear 'mesh': the bearings on 'ground' hold .* 0\.5 m apart.* 0\.1 m"]),
        ({"r1": -0.2, "r2": -0.3}, [r"gear 'mesh': .* two internal gears, -0\.2 and -0\.3"]),
        ({"r1": 0.3, "r2": -0.3}, [r"gear 'mesh': .* add up to 0, 0\.3 and -0\.3"]),
        ({"r2": 0.31}, [r"gear 'mesh': .* 0\.5 m apart, but the radii \(r1, r2\) m mesh at 0\.51"]),
        ({"eccentricity": 0.09}, [r"curve of 'lift' on body 'cam': the profile is not convex"]),
        ({"eccentricity": -0.2, "r2": 0.1}, ["curve of 'lift'", "gear 'mesh'"]),
        ({"width": 0.0}, [r"'roll' on body 'roller': the profile has a corner or a cusp"]),
        ({"width": 0.12}, [r"'roll' on body 'cam': .* radius 0\.12 m, .* hollows is 0\.1176 m"]),
        ({"depth": 0.02}, [r"'roll' on body 'cam': .* 0\.02 m, .* hollows is 0\.003103 m"]),
    ],
    "thrown": [
        ({"shift": -101.0}, [r"spring 'coil': the stiffness shift \+ stiffness is -1 N/m"]),
        ({"shift": 6.0}, [r"dry friction 'rub': the normal force .*pressing.* is -1 N; give"]),
        (
            {"mu": 0.4},
            ["dry friction 'rub': the static coefficient mu_static is 0.3, below .* 0.4"],
        ),
        ({"e": 1.5}, [r"rigid contact 'floor': the restitution e is 1\.5; .* from 0 .* to 1"]),
        ({"e": -0.1}, [r"rigid contact 'floor': the restitution e is -0\.1"]),
        ({"where": 3.5}, ["force 'push': table 'table' is taken at where = 3.5, .* from 0 to 3"]),
        ({"gain": 0.25}, [r"the typical force .* is -4\.905 N"]),
        (
            {"shift": 6.0, "stiffness": -7.0, "e": 2.0, "where": -1.0, "mu": 0.5},
            ["'coil'", "'rub': the normal", "'rub': the static", "'floor'", "'table'"],
        ),
    ],
    "hung": [({"stiffness": -1.0}, [r"spring 'coil': the stiffness .* is -1 N/m"])],
}
RUNS: dict[str, dict[str, Callable[..., object]]] = {
    "turned": {
        "kinematics": lambda m, **given: m.kinematics([0.0, 1.0], **given),
        "inverse_dynamics": lambda m, **given: m.inverse_dynamics([0.0, 1.0], **given),
        "simulate": lambda m, **given: m.simulate(0.1, **given),
        "assemble": lambda m, **given: m.assemble(**given),
    },
    "thrown": {"simulate": lambda m, **given: m.simulate(0.1, **given)},
    "hung": {
        "equilibrium": lambda m, **given: m.equilibrium(**given),
        "settling": lambda m, **given: m.equilibrium("settling", **given),
    },
}


@pytest.fixture(scope="module")
def machines(workshop: Path) -> dict[str, Machine]:
    """The scenes of `conditioned.py`."""
    return {scene: load(MODEL, scene, folder=workshop) for scene in BROKEN}


@pytest.mark.parametrize("scene", BROKEN)
def test_each_run_refuses_what_the_build_refuses(machines: dict[str, Machine], scene: str) -> None:
    for parameters, expected in BROKEN[scene]:
        for run in RUNS[scene].values():
            with pytest.raises(ParameterError) as caught:
                run(machines[scene], parameters=parameters)
            assert len(caught.value.problems) >= len(expected)
            for pattern in expected:
                with pytest.raises(ParameterError, match=pattern):
                    raise caught.value


@pytest.mark.parametrize(
    ("scene", "parameters", "pattern"),
    [(scene, *case) for scene, cases in BROKEN.items() for case in cases],
)
def test_build_refuses_the_same_of_a_scene(
    scene: str, parameters: dict[str, float], pattern: list[str], tmp_path: Path
) -> None:
    """The same list judges the values that a scene gives."""
    file = tmp_path / "given.py"
    line = f"\nmodel.scenes['{scene}'] = replace(model.scenes['{scene}'], "
    line += f"parameters=tuple({parameters}.items()))\n"
    file.write_text("from dataclasses import replace\n" + MODEL.read_text("utf-8") + line, "utf-8")
    with pytest.raises(ModelError) as caught:
        build(file, scene, tmp_path, compile=False)
    for expected in pattern:
        with pytest.raises(ModelError, match=rf"scene '{scene}': .*{expected}"):
            raise caught.value


def test_other_values_run(machines: dict[str, Machine]) -> None:
    assert machines["turned"].kinematics([0.0], parameters={"r1": 0.25, "r2": 0.25}).t.size == 1
    kind = {"mu": 0.3, "e": 1.0, "where": 3.0, "shift": 5.0}
    assert machines["thrown"].simulate(0.1, parameters=kind).outcome is Outcome.OK
    assert machines["hung"].equilibrium(parameters={"shift": -99.0}).outcome is Outcome.OK
