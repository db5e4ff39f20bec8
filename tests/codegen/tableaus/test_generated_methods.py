"""The generated methods are what the tableaus say today, and each of them is registered."""

from fractions import Fraction

import pytest

from codegen.emit.runge_kutta import module_text
from codegen.generated_files.generated_file import write_methods
from codegen.tableaus import tableaus
from codegen.tableaus.tableau import Tableau, difference, stages, weights
from runtime.integrate.method import EXPLICIT, find_method


def test_nothing_is_stale():
    written, stale = write_methods(check=True)
    assert stale == ()
    assert {path.stem for path in written} == set(tableaus())


def test_writing_and_checking(tmp_path):
    written, stale = write_methods(tmp_path)
    assert stale == written
    assert write_methods(tmp_path, check=True)[1] == ()
    written[0].write_text("edited")
    (tmp_path / "no_tableau.py").touch()
    assert write_methods(tmp_path, check=True)[1] == (written[0], tmp_path / "no_tableau.py")


@pytest.mark.parametrize("name", tableaus())
def test_text(name):
    text = module_text(name, tableaus()[name])
    assert max(map(len, text.splitlines())) <= 100
    assert " 0.0 * " not in text  # no zero of the tableau is multiplied
    compile(text, name, "exec")


def test_text_of_a_small_method():
    # P. Bogacki and L. F. Shampine's 3(2): a zero in a row, no row of the dense output of its own.
    b = weights("2/9 1/3 4/9")
    tableau = Tableau(
        about="Order 3(2).", order=3, error_order=2, stages=stages("1/2 | 1/2\n 3/4 | 0 3/4"),
        b=b, error=difference(b, weights("7/24 1/4 1/3 1/8")), dense_order=3, dense=(),
        beta=0.04, safety=0.9, shrink=0.2, grow=10.0,
    )  # fmt: skip
    text = module_text("small", tableau)
    assert "        z[j] = y0[j] + h * (0.75 * k2[j])\n" in text
    assert "    taken += evaluate_rhs(context, t + 0.75 * h, ws.STAGE, ws.K + 2)\n" in text
    assert (
        "        estimate = h * (\n"
        "            -0.06944444444444445 * k1[j] + 0.08333333333333333 * k2[j] "
        "+ 0.1111111111111111 * k3[j]\n"
        "            - 0.125 * k4[j]\n"
        "        )\n"
    ) in text
    assert "    hermite_rows(context, h, ws.K + 3)\n    return 0\n" in text
    assert "    dense_rows=4,\n" in text


def test_every_tableau_is_a_method():
    assert set(tableaus()) == set(EXPLICIT)
    for name, tableau in tableaus().items():
        method = find_method(name)
        assert method.estimate_order == tableau.error_order + 1
        assert method.last == method.stage_calls + 1 == tableau.last


def test_reading_of_numbers():
    rows = stages("""
        1/2 | 0.5
        3/4 | 0
              3/4
    """)
    assert rows[1] == (Fraction(3, 4), (Fraction(0), Fraction(3, 4)))
    assert difference(weights("1 1/3"), weights("0.5 1/3 -1/8")) == weights("1/2 0 1/8")
