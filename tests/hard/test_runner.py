"""The runner finds what is wrong: a cell that lies, one that hangs, one that stops."""

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer

from codegen.errors import AnalysisError
from models.hard.__main__ import main, tolerances
from models.hard.cases import CASES, GROUPS, find
from models.hard.suite.case import Array, Case, Reference
from models.hard.suite.cell import COMPARED, SETTINGS, Cell, Setting, Verdict, run, suits
from models.hard.suite.page import markdown
from models.hard.suite.worker import Worker
from runtime import Result
from runtime.integrate.method import REGISTER
from runtime.machine_facade import Machine

SETTING = Setting(COMPARED, "step")
ONE = find("one_step")


def cell_of(case: Case, rtol: float = 1e-6) -> Cell:
    return run(case, SETTING, rtol)


def test_a_right_run_is_correct() -> None:
    cell = cell_of(ONE)
    assert cell.verdict is Verdict.CORRECT
    assert cell.note == ""
    assert cell.until == ONE.t_end


@pytest.mark.parametrize("off", [1e-3, -1e-3, np.nan])
def test_a_run_that_lies_is_found(off: float) -> None:
    cell = cell_of(replace(ONE, measure=lambda run: ONE.measure(run) + off))
    assert cell.verdict is Verdict.WRONG
    assert cell.outcome == "OK"
    assert "off by 1.0e-03" in cell.note or "not finite" in cell.note


def test_a_number_too_few_is_found() -> None:
    cell = cell_of(replace(ONE, measure=lambda run: ONE.measure(run)[:-1]))
    assert cell.verdict is Verdict.WRONG
    assert "1 numbers where there should be 2" in cell.note


def test_a_residual_that_is_too_large_is_found() -> None:
    def bent(run: Result) -> Array:
        run.samples.residual[:, 0] = 1e-9
        return ONE.measure(run)

    cell = cell_of(replace(ONE, measure=bent))
    assert cell.verdict is Verdict.WRONG
    assert "1.0e-09" in cell.note


def test_an_unexpected_end_says_its_name_and_an_expected_one_is_fine() -> None:
    short = replace(find("dense_outputs"), options={"max_steps": 3})
    cell = cell_of(short)
    assert cell.verdict is Verdict.STOPPED
    assert "Stopped at" in cell.note
    assert cell.reached < short.t_end
    fine = cell_of(replace(short, ends=("MAX_STEPS",)))
    assert fine.verdict is Verdict.WRONG  # it has not got all its numbers
    ended = replace(short, ends=("MAX_STEPS",), measure=lambda run: short.reference().values)
    assert cell_of(ended).verdict is Verdict.EXPECTED


def test_what_stops_is_still_compared_up_to_there() -> None:
    short = replace(find("dense_outputs"), options={"max_steps": 3})
    assert cell_of(replace(short, measure=lambda run: run.q("bar.phi")[:, None] + 0.1)).verdict is (
        Verdict.WRONG
    )


def test_what_cannot_be_told_is_not_called_correct() -> None:
    reference = ONE.reference()
    far = Reference(reference.values, reference.times, 1e9, 1, 0.0)
    assert cell_of(replace(ONE, reference=lambda: far)).verdict is Verdict.BEYOND


def test_a_refusal_says_why_and_is_fine_where_it_is_expected(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AnalysisError("bdf cannot do this")

    monkeypatch.setattr(Machine, "simulate", refuse)
    cell = run(replace(ONE, ends=("OK", "REFUSED")), SETTING, 1e-6)
    assert cell.verdict is Verdict.EXPECTED
    assert (cell.outcome, cell.note, cell.steps) == ("REFUSED", "", 0)
    assert cell.message == "bdf cannot do this"
    other = run(ONE, SETTING, 1e-6)
    assert other.verdict is Verdict.STOPPED
    assert other.note == other.message


def endless(name: str) -> Case:
    """A case whose measuring never ends in time."""

    def measure(run: Result) -> Array:
        time.sleep(60.0)
        return ONE.measure(run)

    return replace(ONE, measure=measure) if name == "endless" else find(name)


@pytest.mark.slow
def test_what_hangs_is_given_up_and_the_next_cell_runs() -> None:
    worker = Worker(endless, limit=2.0)
    hanging = worker.run(replace(ONE, name="endless"), SETTING, 1e-6)
    assert hanging.verdict is Verdict.HANGS
    assert "no answer after 2 s" in hanging.note
    worker.limit = 30.0
    assert worker.run(ONE, SETTING, 1e-6).verdict is Verdict.CORRECT
    worker.close()


def test_what_cannot_run_is_raised_with_its_reason() -> None:
    worker = Worker(find)
    with pytest.raises(RuntimeError, match="StopIteration"):
        worker.run(replace(ONE, name="nothing"), SETTING, 1e-6)
    worker.close()


def test_the_page_has_every_cell_and_its_note() -> None:
    cells = [cell_of(ONE), Cell.hanging("one_step", SETTING, 1e-3, 5.0)]
    text = markdown(GROUPS, cells)
    assert "### one_step" in text
    assert "### andrews" not in text
    assert "| [one_step](#one_step) | 2 | 1 | 0 | 0 | 0 | 1 | 0 |" in text
    assert "**HANGS**" in text
    assert "- dop853, step, rtol 1e-03: no answer after 5 s" in text
    assert json.loads(json.dumps(cells[1].record()))["error"] is None


def test_a_bound_grows_with_the_tolerance_and_the_time() -> None:
    for case in CASES:
        reference = case.reference()
        assert reference.values.shape[0] == len(reference.times)
        assert (np.diff(reference.times) >= 0.0).all()
        loose, tight = reference.bound(1e-6), reference.bound(1e-12)
        assert (loose > tight).all()
        assert (tight > 0.0).all()
        # The tightest tolerance must tell right from wrong at some instant.
        assert reference.bound(case.tolerances[-1]).min() < 1e-4


def test_a_method_of_low_order_takes_more_steps_which_add_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tight = replace(find("one_step").reference(), trusted=0.0)
    assert (tight.bound(1e-9, 5) == tight.bound(1e-9)).all()
    np.testing.assert_allclose(tight.bound(1e-9, 3), 1e-9 ** (1 / 5 - 1 / 3) * tight.bound(1e-9))
    usual = cell_of(ONE)
    monkeypatch.setitem(REGISTER, COMPARED, REGISTER[COMPARED]._replace(order=3))
    assert cell_of(ONE).bound > 5.0 * usual.bound  # 1e-6^(1/5 - 1/3) = 6.3


def test_names_are_unique_and_every_way_has_its_place() -> None:
    assert len({case.name for case in CASES}) == len(CASES)
    assert len(set(SETTINGS)) == len(SETTINGS)
    assert tolerances(find("andrews"), quick=True) == (1e-9,)


def test_what_is_too_long_to_compile_is_run_by_explicit_methods_alone() -> None:
    suitable = [setting.method for setting in SETTINGS if suits(find("n_four_bar_40"), setting)]
    assert "bdf" not in suitable
    assert suits(find("n_four_bar_40"), Setting("dopri5", "step"))
    assert all(suits(find("n_four_bar_5"), setting) for setting in SETTINGS)


def test_an_unknown_name_is_refused(tmp_path: Path) -> None:
    with pytest.raises(typer.BadParameter, match="'andrew' is none of"):
        main(only=["andrew"], results=tmp_path / "cells.jsonl")
    with pytest.raises(typer.BadParameter, match="'euler' is none of"):
        main(method=["euler"], results=tmp_path / "cells.jsonl")


def test_a_run_of_one_case_leaves_the_page_alone(tmp_path: Path, root: Path) -> None:
    page = root / "benchmarks" / "results" / "hard-cases.md"
    before = page.read_bytes()
    out, cells = tmp_path / "page.md", tmp_path / "cells.jsonl"
    main(only=["one_step"], method=[COMPARED], quick=True, out=out, results=cells)
    assert page.read_bytes() == before
    assert "### one_step" in out.read_text(encoding="utf-8")
    lines = [json.loads(line) for line in cells.read_text(encoding="utf-8").splitlines()]
    assert [line["case"] for line in lines] == ["one_step"] * len(lines)
