"""Section 8.4 of the book: surge waves by their closed form, impact by an independent solution."""

from itertools import pairwise
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from models.coil_spring import machine
from models.studies.coil_spring import arrival, estimate, frequencies, modal, separations, table
from runtime import Machine, Outcome, Result, load

DATA = Path(__file__).parent.parent / "data"
RTOL = 1e-12


def read(name: str) -> np.ndarray:
    """A table of tests/data."""
    return np.genfromtxt(DATA / name, delimiter=",", names=True, dtype=None, encoding="ascii")


def struck(chain: Machine, count: int, t_end: float, **parameters: float) -> Result:
    """The surge scene, sampled every 5 ms."""
    instants = np.linspace(0.0, t_end, round(t_end / 5e-3) + 1)
    run = chain.simulate(t_end, instants, rtol=RTOL, parameters=parameters)
    assert run.outcome is Outcome.OK
    assert len(run.description.coordinates) == 3 * count
    return run


def positions(run: Result, count: int) -> np.ndarray:
    """Positions of the masses, shape (count, k)."""
    return np.array([run.q(f"mass_{i}.x") for i in range(1, count + 1)])


def energy_is_kept(scene: str, t_end: float, **parameters: float) -> None:
    """Kinetic and potential energy keep their sum to what the method lets go in 1000 steps."""
    run = load("coil_spring", scene).simulate(t_end, rtol=RTOL, parameters=parameters)
    energy = run.energy()
    assert np.abs(energy - energy[0]).max() < 200 * RTOL * energy[0]


# -- surge waves ---------------------------------------------------------------------------------


def test_surge_follows_the_reference() -> None:
    wanted = read("coil_spring_surge.csv")
    run = load("coil_spring", "surge").simulate(wanted["t"][-1], wanted["t"], rtol=RTOL)
    for i in range(1, 7):
        assert np.abs(run.q(f"mass_{i}.x") - wanted[f"x{i}"]).max() < 1e-11
        assert np.abs(run.v(f"mass_{i}.x") - wanted[f"v{i}"]).max() < 1e-10


def test_surge_is_the_sum_of_its_modes_for_20_seconds() -> None:
    run = struck(load("coil_spring", "surge"), 6, 20.0)
    exact = 0.2 * np.arange(1, 7)[:, None] + modal(run.t, 6, 200.0, 2.5)
    assert np.abs(positions(run, 6) - exact).max() < 1e-9
    energy_is_kept("surge", 20.0)
    assert np.abs(run.data["constraint_residual"]).max() < 1e-12


def test_frequencies_at_rest_are_those_of_the_chain() -> None:
    rest = load("coil_spring", "surge").equilibrium(guess={"mass_3.x": 0.65})
    assert rest.stable
    for i in range(1, 7):
        assert abs(rest[f"mass_{i}.x"] - 0.2 * i) < 1e-12
    exact = frequencies(6, 200.0, 2.5) / (2 * pi)
    np.testing.assert_allclose(sorted(rest.frequencies), exact, rtol=1e-9)


@pytest.mark.parametrize(("k", "m"), [(50.0, 2.5), (200.0, 10.0), (800.0, 2.5)])
def test_wave_runs_as_the_root_of_stiffness_over_mass(k: float, m: float) -> None:
    chain = load("coil_spring", "surge")
    first, other = struck(chain, 6, 2.0), struck(chain, 6, 2.0, k=k, m=m)
    times = [arrival(r.t, r.v("mass_1.x"), r.a("mass_1.x")) for r in (first, other)]
    assert times[1] / times[0] == pytest.approx(sqrt(200 / 2.5 * m / k), rel=1e-4)


def test_wave_nears_the_speed_of_a_continuum_as_masses_grow_in_number(
    request: pytest.FixtureRequest,
) -> None:
    """The front of a lattice lags behind c = ℓ0 √(k/m), by a share that falls as n grows."""
    kept: Path = request.config.cache.mkdir("coil-spring")  # compiled once
    counts, speed, lags, delays = (6, 9, 12), 0.2 * sqrt(200 / 2.5), [], []
    for count in counts:
        declared = "coil_spring" if count == 6 else machine(count)
        chain = load(declared, "surge", folder=kept / str(count))
        run = struck(chain, count, 0.2 * count / speed * 1.4)
        exact = 0.2 * np.arange(1, count + 1)[:, None] + modal(run.t, count, 200.0, 2.5)
        assert np.abs(positions(run, count) - exact).max() < 1e-9
        passes = arrival(run.t, run.v("mass_1.x"), run.a("mass_1.x"))
        lags.append(1 - 0.2 * (count - 1) / passes / speed)
        delays.append(passes * speed / 0.2 - (count - 1))
    assert 0.2 > lags[0] > lags[1] > lags[2] > 0
    # ω = 2 √(k/m) sin(κ/2) = √(k/m) (κ - κ³/24 + …): after n springs the front is as wide as the
    # cube root of n, and its peak behind by a number of masses that grows, but no faster.
    for (few, early), (many, late) in pairwise(zip(counts, delays, strict=True)):
        assert 1.0 < late / early < ((many - 1) / (few - 1)) ** (1 / 3)


# -- impact --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "events"),
    [
        ("impact", "coil_spring_impact_k50_events.csv"),
        ("impact_damped", "coil_spring_impact_k50_damped_events.csv"),
    ],
)
def test_every_contact_is_located(scene: str, events: str) -> None:
    wanted = read(events)[1:]  # the first contact begins with the run
    run = load("coil_spring", scene).simulate(16.0, rtol=RTOL)
    assert run.outcome is Outcome.OK
    assert [e.direction for e in run.events] == [1 if e == "on" else -1 for e in wanted["event"]]
    times = np.array([e.time for e in run.events])
    early = wanted["t"] < 5.0
    assert early.sum() > 15
    assert np.abs(times - wanted["t"])[early].max() < 1e-8
    assert np.abs(times - wanted["t"]).max() < 1e-7
    names = run.description.coordinates.names
    for body, velocity in (("mass_6", "v6"), ("striker", "v8")):
        place = names.index(f"{body}.x")
        x = np.array([e.q[place] for e in run.events])
        v = np.array([e.v[place] for e in run.events])
        assert np.abs(x - 1.2 - wanted["u6u8"]).max() < 1e-8
        assert np.abs(v - wanted[velocity])[early].max() < 1e-7


@pytest.mark.parametrize("k", [50.0, 40.0, 30.0])
def test_impact_keeps_its_energy_and_ends(k: float) -> None:
    instants = np.linspace(0.0, 18.0, 3601)
    run = load("coil_spring", "impact").simulate(18.0, instants, rtol=RTOL, parameters={"k": k})
    energy_is_kept("impact", 18.0, k=k)
    assert len(separations(run)) == (30 if k == 50.0 else 31)
    left = run.t > separations(run)[-1][0]
    assert np.ptp(run.v("striker.x")[left]) < 1e-12
    assert (run.q("striker.x") > run.q("mass_6.x"))[left].all()


def test_damper_takes_the_energy_that_is_missing() -> None:
    instants = np.linspace(0.0, 0.0048, 2001)  # within the first contact: smooth
    run = load("coil_spring", "impact_damped").simulate(0.0049, instants, rtol=RTOL)
    assert not run.events
    lost = run.power("damped_contact", "nonconservative")
    assert lost[0] == 0  # at the very start the bodies just touch
    power, h = lost[200:], instants[1]
    work = h / 3 * (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-2:2].sum())
    energy = run.energy()[200:]
    assert (power <= 0).all()
    assert work < -1e-4
    assert energy[-1] - energy[0] == pytest.approx(work, rel=1e-9)


def test_damping_ends_chattering_sooner() -> None:
    """What the book observes: smaller gaps, shorter periods, the same end of the single wave."""
    instants = np.linspace(0.0, 16.0, 16001)
    free, damped = (
        load("coil_spring", scene).simulate(16.0, instants, rtol=RTOL)
        for scene in ("impact", "impact_damped")
    )
    gaps = []
    for run in (free, damped):
        together = run.t < 5.0
        gaps.append((run.q("striker.x") - run.q("mass_6.x"))[together].max())
    assert gaps[1] < gaps[0]
    assert separations(damped)[1][0] < separations(free)[1][0]
    assert abs(separations(damped)[-1][0] - separations(free)[-1][0]) < 0.2


def test_the_estimate_bounds_the_deflection_and_nears_it_as_the_spring_grows_light() -> None:
    """Without mass in the spring all energy of the striker is in the springs at the deepest point.

    With masses the striker keeps less for them: the estimate is too large by a share that falls
    with the mass of the spring over that of the striker. The contact gives way, too: it is a
    seventh spring, of a stiffness of 20 000 times that of the others.
    """
    assert estimate(load("coil_spring", "impact").simulate(0.001)) == pytest.approx(sqrt(6 / 50))
    shares = []
    for m in (2.5, 0.25, 0.025):
        instants = np.linspace(0.0, 8.0, 8001)
        run = load("coil_spring", "impact").simulate(8.0, instants, rtol=1e-10, parameters={"m": m})
        x = run.q("striker.x")
        shares.append((x[0] - x.min()) / estimate(run))
    assert shares[0] < shares[1] < shares[2] < sqrt(1 + 50 / 6e6)
    assert shares[0] == pytest.approx(0.326739 / 0.346410, rel=1e-5)
    lags = [1 - share for share in shares]
    for heavy, light in pairwise(lags):
        assert 0.15 < light / heavy < 0.2


def test_every_row_of_the_study_is_exact_and_says_why_the_book_differs() -> None:
    for row in table():
        assert abs(row.ours - row.exact) < 2e-8 * max(1.0, abs(row.exact)), row
        if row.book is not None and abs(row.exact - row.book) > 1e-3:
            assert row.reason, row


# -- in other lumps ------------------------------------------------------------------------------


def test_spring_may_be_of_any_of_several_numbers_of_masses() -> None:
    """Each its own scene, with the blow of the book's: the last lump's m v is that of six."""
    model = machine(6, 3, 12)
    assert list(model.groups["lumps"]) == ["6", "3", "12"]
    assert [name for name in model.scenes if name.startswith("surge")] == [
        "surge", "surge_3", "surge_12",
    ]  # fmt: skip
    for count in (3, 12):
        asked = model.scenes[f"surge_{count}"]
        assert len(asked.bodies) == count
        start = dict(asked.start)
        length = start[f"lump_{count}_of_{count}.x"]
        assert float(length) == pytest.approx(6 * 0.2)
        assert float(start[f"lump_{count}_of_{count}.vx"]) == pytest.approx(-0.1 * count / 6)


@pytest.mark.slow
def test_number_of_masses_is_a_fidelity_of_the_scene(tmp_path: Path) -> None:
    """Six masses unless the scene says twelve: the same spring, and the waves of either chain."""
    model = machine(6, 12)
    coarse = struck(load(model, "surge", folder=tmp_path), 6, 4.0)
    exact = 0.2 * np.arange(1, 7)[:, None] + modal(coarse.t, 6, 200.0, 2.5)
    assert np.abs(positions(coarse, 6) - exact).max() < 1e-9
    fine = struck(load(model, "surge_12", folder=tmp_path), 12, 4.0)
    found = np.array([fine.q(f"lump_{i}_of_12.x") for i in range(1, 13)])
    # The modes are those of a last mass that starts with -0.1 m/s; here it is twice as fast.
    exact = 0.1 * np.arange(1, 13)[:, None] + 2 * modal(fine.t, 12, 400.0, 1.25)
    assert np.abs(found - exact).max() < 1e-9
    assert not {"mass_1", "contact"} & {*fine.description.bodies, *fine.description.effects.names}
    asked = model.scene("surge").with_(fidelity={"lumps": "12"})
    assert len(asked.bodies) == 12
    assert "mass_1.x" not in dict(asked.start)
