"""What a user holds: tables, parameters, modes, summary."""

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError, LinkwrightError, ParameterError, UnknownNameError
from runtime import Outcome
from runtime.machine_facade import Machine
from runtime.mechanism.table_rows import Coordinate, Table
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result
from runtime.statics.equilibrium import Equilibrium
from runtime.studies.diagram import WorkPrecision
from runtime.studies.ranking import Matters


def test_tables_answer_to_position_and_name(driven: Machine) -> None:
    assert driven.coordinates[2].name == "crank.phi"
    assert driven.coordinates["crank.phi"].velocity == "crank.omega"
    assert driven.coordinates.index("slider.x") == 6
    assert "rod.phi" in driven.coordinates
    assert "rod.psi" not in driven.coordinates
    assert driven.constraints.names[-1] == "crank_drive.phi"
    assert driven.effects.names == ("gravity",)
    with pytest.raises(KeyError, match=r"no name 'crank\.fi'; nearest: crank\.phi"):
        driven.coordinates["crank.fi"]


def test_parameters_are_followed_by_their_constants(free: Machine) -> None:
    p = free.parameter_values({"l": 3.0, "J1": 900})
    assert p.dtype == np.float64
    assert p[free.parameters.index("l")] == 3.0
    assert p[free.parameters.index("J1")] == 900.0
    assert p[len(free.parameters) :].tolist() == [0.0, 1.5, -1.5]


def test_all_problems_with_parameters_are_told_at_once(free: Machine) -> None:
    wrong = {"J11": 1.0, "m1": 0.0, "gx": math.inf, "l": "long"}
    with pytest.raises(ParameterError) as caught:
        free.parameter_values(wrong)  # type: ignore[arg-type]
    problems = caught.value.problems
    assert len(problems) == 4
    assert "no parameter 'J11'; nearest: J1" in problems[0]
    assert problems[1] == "Parameter m1 is 0 kg; it must be greater than zero."
    assert "gx is inf; it must be a finite number" in problems[2]
    assert problems[3] == "Parameter l is 'long'; it must be a finite number in m."


def test_method_that_there_is_not_has_hints(free: Machine) -> None:
    with pytest.raises(AttributeError, match=r"Machine has no 'simulat'; did you mean simulate"):
        free.simulat(1.0)


def test_modes_follow_the_motion(gas: Machine) -> None:
    assert gas.initial_modes().dtype == np.int64
    q = gas.assemble().q
    forwards, backwards = np.zeros(9), np.zeros(9)
    forwards[6], backwards[6] = 1.0, -1.0
    assert gas.initial_modes(0.0, q, forwards).tolist() == [1]
    assert gas.initial_modes(0.0, q, backwards).tolist() == [0]


def test_mode_at_its_boundary_follows_the_rate(gas: Machine) -> None:
    """From rest with the crank at 0.8 rad, gravity pulls the slider outwards."""
    start = gas.assemble()
    assert start["slider.vx"] == 0.0
    assert gas.initial_modes(parameters={"push": -1.0}).tolist() == [1]
    assert gas.initial_modes(parameters={"push": -1.0, "gy": 9.81}).tolist() == [0]


def test_mode_that_is_pushed_back_from_both_sides_stays_between(
    gas: Machine, free: Machine
) -> None:
    assert gas.initial_modes().tolist() == [2]
    assert free.initial_modes().shape == (0,)  # without a switch


def test_summary_names_what_matters(driven: Machine, free: Machine) -> None:
    assert (free.degrees_of_freedom, driven.degrees_of_freedom) == (1, 0)
    text = repr(driven)
    assert "sc_driven/driven: 3 bodies, 9 coordinates, 9 constraints (1 of drivers)" in text
    assert "crank, rod, slider" in text
    assert "J1 = 450 kg m^2" in text
    html = driven._repr_html_()
    assert "<td>J1</td><td style='text-align:right'>450</td><td>kg m^2</td>" in html


def test_kernels_are_callable(driven: Machine) -> None:
    start = driven.assemble()
    a, lam = np.zeros(9), np.zeros(9)
    weak = driven.kernels.accelerations(
        0.0, start.q, start.v, driven.parameter_values(), driven.initial_modes(), a, lam
    )
    assert weak == 0
    assert abs(a[2]) < 1e-10


def test_tables_are_read_and_not_replaced(driven: Machine) -> None:
    for name in ("description", "kernels", "path", "model", "scene"):
        with pytest.raises(AttributeError):
            setattr(driven, name, None)
    for name in ("coordinates", "constraints", "parameters", "effects"):
        with pytest.raises(AttributeError):
            setattr(driven, name, {})
        assert getattr(Machine, name).__doc__


def test_attributes_of_a_subclass_of_a_users_are_its_own(driven: Machine) -> None:
    class Named(Machine):
        nickname = ""

    machine = Named(driven.mechanism)
    machine.nickname = "the old one"
    assert machine.nickname == "the old one"


WRONG: dict[str, Callable[[Machine], Any]] = {
    "'x' is no mechanism": lambda of: Machine("x"),  # type: ignore[arg-type]
    "Result.facts: too many positional arguments; it takes ()": lambda of: result(of).facts(3),  # type: ignore[call-arg]
    "Equilibrium.facts: too many positional arguments; it takes ()": lambda of: Equilibrium.facts(
        object.__new__(Equilibrium), 3  # type: ignore[call-arg]
    ),
    "Result.q: missing a required": lambda of: result(of).q(),  # type: ignore[call-arg]
    "Result.power: too many": lambda of: result(of).power("a", "b", "c", "d"),  # type: ignore[call-arg]
    "Machine.assemble: too many": lambda of: of.assemble(1, 2, 3, 4),  # type: ignore[call-arg, arg-type]
    "power: missing a required": lambda of: Result.power(),  # type: ignore[call-arg]
    "Assembly: missing a required argument": lambda of: Assembly(),  # type: ignore[call-arg]
    "Matters.facts": lambda of: study(Matters).facts(foo=3),
    "no effect [1]; there are: .": lambda of: study(Matters)[[1]],
    "WorkPrecision.facts": lambda of: study(WorkPrecision).facts(foo=3),
    "no setting None; there are: .": lambda of: study(WorkPrecision)[None],
}  # fmt: skip


def result(machine: Machine) -> Result:
    """A result of the machine."""
    return machine.kinematics([0.0], progress=False)


def study(kind: Any) -> Any:
    """A study that has found nothing."""
    made = object.__new__(kind)
    vars(made).update(rows=(), lines=())
    return made


@pytest.mark.parametrize("start", WRONG)
def test_wrong_calls_of_results_and_studies_are_errors_of_ours(driven: Machine, start: str) -> None:
    with pytest.raises(InputError) as caught:
        WRONG[start](driven)
    assert str(caught.value).startswith(start)


ROWS: Table[Coordinate] = Table([Coordinate("a.x", "a.vx", "m"), Coordinate("a.y", "a.vy", "m")])


ODD = [None, 1.0, 99, [0], "z", b"a.x", float("nan")]


@pytest.mark.parametrize("odd", ODD)
def test_a_row_that_is_none_is_refused(odd: Any) -> None:
    assert odd not in ROWS
    with pytest.raises(UnknownNameError, match=r"There is no (row|name) .*there are: a\.x, a\.y"):
        ROWS[odd]
    with pytest.raises(UnknownNameError, match="There is no name"):
        ROWS.index(odd)


def test_rows_are_found_by_name_position_and_as_themselves() -> None:
    assert ROWS["a.y"] is ROWS[1] is ROWS[np.int64(-1)] is ROWS[ROWS[1]]  # type: ignore[index]
    assert ROWS[:1] == (ROWS[0],)
    assert "a.x" in ROWS
    assert ROWS[0] in ROWS


@pytest.mark.parametrize("given", [None, 99, -1, 1.5, "OK"])
def test_no_outcome_is_made_of_what_is_none(given: Any) -> None:
    with pytest.raises(InputError, match=r"Outcome\(.*number of an outcome, 0 to 15"):
        Outcome(given)


def test_outcomes_are_found_by_number() -> None:
    assert Outcome(3) is Outcome(np.int64(3)) is pickle.loads(pickle.dumps(Outcome(3)))
    assert issubclass(InputError, LinkwrightError)
