"""A tracked point that bears the name of a joint: pin C at point C."""

from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_array_equal

from codegen import Model, t
from codegen.explain.declaration_report import check_declaration
from runtime import load, load_result


def linkage(point: str, *, first: bool = True, released: bool = False, **scene: Any) -> Model:
    """Two bars, the pin C between them, and a tracked point at its place."""
    model = Model(f"linkage_{point}", gravity=(0, -9.81))
    crank = model.body("crank", mass=1.0, inertia=0.1)
    rod = model.body("rod", mass=1.0, inertia=0.1)
    model.revolute("A", model.ground.at(0, 0), crank.at(-1, 0))
    if first:
        model.track(point, crank.at(1, 0))
    model.revolute("C", crank.at(1, 0), rod.at(-1, 0))
    if not first:
        model.track(point, crank.at(1, 0))
    if released:
        model.release("C", when=t > 0.5)
    model.driver("drive", crank.phi, 0.5 * t)
    model.scene("run", ["gravity"], ["drive"], start={rod.phi: 0.3, rod.omega: 0.0}, **scene)
    return model


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize(
    "outputs", [None, [], ["points"], ["point(C)"], ["reaction(C)"], ["points", "reactions"]]
)
def test_results_are_those_of_a_point_of_another_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, outputs: list[str] | None, first: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    others = outputs and [word.replace("point(C)", "point(Q)") for word in outputs]
    shared = load(linkage("C", first=first, outputs=outputs)).simulate(1.0, 11)
    apart = load(linkage("Q", first=first, outputs=others)).simulate(1.0, 11)
    here, there = shared.description, apart.description
    names = [(row.name.replace("Q", "C"), row.kind, row.unit) for row in there.series]
    assert [(row.name, row.kind, row.unit) for row in here.series] == names
    idle = [(row.name.replace("Q", "C"), row.kind) for row in there.left_out]
    assert [(row.name, row.kind) for row in here.left_out] == idle
    assert_array_equal(shared.point("C"), apart.point("Q"))
    assert_array_equal(shared["C.fx"], apart["C.fx"])
    assert_array_equal(shared["C.vy"], apart["Q.vy"])
    assert_array_equal(shared.reaction("C", "fy"), shared.force("C", "fy"))


def test_the_text_of_a_result_has_the_joint_beside_the_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = repr(load(linkage("C", outputs=["default", "points"])).simulate(1.0, 11)).splitlines()
    assert "  reactions    A, C, drive (N, N m)" in lines
    assert "  points       C (m)" in lines


def test_files_and_pictures_keep_the_two_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    machine = load(linkage("C", outputs=["points", "reactions"]))
    r = machine.simulate(1.0, 11)
    assert_array_equal(r.data["point"].sel(place="C", axis="x"), r.point("C")[:, 0])
    assert_array_equal(r.data["reaction"].sel(joint="C", component="fx"), r["C.fx"])
    r.save("run.nc")
    assert_array_equal(load_result("run.nc").point("C"), r.point("C"))
    (path,) = r.plot("C").axes
    assert path.get_xlabel() == "x (m)"
    letters = [text.get_text() for text in r.draw(0.5).axes[0].texts]
    assert letters.count("C") == 1


def test_point_stays_where_its_joint_is_released_or_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["point(C)", "reaction(C)"]
    r = load(linkage("C", released=True, outputs=words)).simulate(1.0, 11)
    others = ["point(Q)", "reaction(C)"]
    apart = load(linkage("Q", released=True, outputs=others)).simulate(1.0, 11)
    assert_array_equal(r.point("C"), apart.point("Q"))
    assert_array_equal(r["C.fx"], apart["C.fx"])
    model = linkage("C", outputs=["points"])
    open_ = model.scene("run").without("C")
    assert open_.name == "run_without_C"
    assert open_.inactive_joints == ("C",)
    assert open_.effects == ("gravity", "C")
    assert open_.with_("C").inactive_joints == ()


def test_report_knows_that_the_joint_takes_part() -> None:
    report = check_declaration(linkage("C"))
    assert report.scenes[0].one_joint == {"rod": "C"}
    assert report.scenes[0].left_out == ()
    assert not report.unused


def test_a_name_in_a_list_is_the_joints_and_no_other_name_is_shared() -> None:
    model = linkage("C")
    model.scene("named", ["C"])
    assert "it is a joint, which takes part" in model.problems[-1]
    for declare, kind in (
        (lambda m: m.track("C", m.bodies["rod"]), "tracked point 'C'"),
        (lambda m: m.revolute("C", m.ground, m.bodies["rod"]), "joint 'C'"),
        (lambda m: m.torque("C", m.bodies["rod"], 1.0), "effect 'C'"),
        (lambda m: m.track("drive", m.bodies["rod"]), "tracked point 'drive'"),
        (lambda m: m.track("rod", m.bodies["rod"]), "tracked point 'rod'"),
    ):
        for first in (True, False):
            model = linkage("C", first=first)
            declare(model)
            assert f"{kind}: the name is already that of a " in model.problems[-1]
