"""The machine that a user holds: the analyses as methods, beside its tables and states."""

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from codegen.readers.calls import checked_class, named_attributes
from runtime.machine_states import MachineStates
from runtime.mechanism.mechanism import Values
from runtime.progress_bar import bar, shows_compilation
from runtime.validation.arguments import check, instants_of_motion
from runtime.validation.scene_support import refuse_states, require_energy, require_motion

if TYPE_CHECKING:
    import xarray as xr

    from runtime.dynamics.controllers import Functions
    from runtime.dynamics.output_conditions import Conditions
    from runtime.integrate.problem import Correction, Formulation
    from runtime.results.assembled_state import Assembly, State
    from runtime.results.result import Result
    from runtime.statics.equilibrium import Equilibrium
    from runtime.sweeps.ensemble_arguments import Columns

# arguments of `simulate` that choose between given tolerances and a search for an accuracy
_SETTINGS = ("accuracy", "rtol", "atol", "quantities", "method", "formulation")


@named_attributes
@checked_class
class Machine(MachineStates):
    """A mechanism in one scene, ready to be analysed; `load` returns one."""

    @shows_compilation
    def simulate(
        self, t_end: float, t_eval: "npt.ArrayLike | int | str | None" = None, *,
        accuracy: float | None = None, quantities: Sequence[str] | None = None,
        t_start: float = 0.0, method: str | None = None, rtol: float | None = None,
        atol: float | None = None, parameters: Values | None = None,
        guess: Values | None = None, start: "Assembly | State | Result | Values | None" = None,
        controllers: "Functions | None" = None, until: "Conditions | None" = None,
        correction: "Correction" = "step", formulation: "Formulation | None" = None,
        time_scale: float | None = None, first_step: float | None = None,
        max_step: float | None = None, max_steps: int | None = None,
        max_bytes: int = 2**30, out: str | os.PathLike[str] | None = None, progress: bool = True,
    ) -> "Result":  # fmt: skip
        """Integrate the equations of motion from the assembled start.

        Parameters
        ----------
        t_end, t_eval
            Last instant in s. Output instants in s, increasing; or their number, at equal
            distances, by default 501; or "steps", the end of every step. `Result.at` returns all
            others.
        accuracy, quantities
            The largest relative global error of the result, from 1e-12 to 0.1, and the names of the
            series to which it applies, by default the whole state. The program then chooses the
            tolerances, and method and formulation unless they are given; `Result.accuracy` has the
            error that was reached.
        t_start, guess, start
            First instant in s, by default the instant of `start`, or 0. `start` sets values by name
            of coordinate (m, rad) or velocity (m/s, rad/s) in place of the scene's; values that the
            joints do not allow are refused. Or `start` is a state: an assembled one, an
            equilibrium, `Result.state(t)`, or a result, for its end. Where joints come and go, such
            a run begins with the joints that act in this state. `guess` has the values at which the
            search for a start begins, in place of the scene's guesses; a name that the scene fixes
            is refused. `Result.message` says how far values were moved.
        method
            "dop853" (default), of order 8, "dopri5" and "tsit5", of order 5, are explicit. "radau5"
            and "bdf" are implicit, for stiff equations: contacts and springs that vibrate much
            faster than the machine moves; take "radau5" if these vibrations are lightly damped.
            "auto" starts with "dop853", changes to an implicit method where the equations are
            stiff, and changes back. The last three need exact derivatives, which are built at the
            first use.
        formulation
            "cartesian" (default) integrates all coordinates, "reduced" only those that do not
            follow explicitly from constraints; the results are the same.
        rtol, atol
            A step has an error below `atol` + `rtol` times the value, for each coordinate and
            velocity: `rtol` is 1e-8 by default; `atol`, in m, rad, m/s or rad/s, is by default
            `rtol` times a typical size. The typical size of an angle is 1 rad. The typical size of
            a length is the size of the machine at its start (its longest arm; without arms its
            largest distance from the origin, or a fixed length), but not more than 1 m. Velocities
            have the same sizes per second.
        parameters
            Values by name, SI units or texts, ``"45 mm"``; the others keep their defaults.
        controllers
            Sampled value that is declared without an expression → a function of yours that computes
            it at each of its samples, ``lambda sample: -4.0 * sample.q("arm.phi")``, from
            `Sample.t`, `q`, `v` and `y`. A call takes some microseconds; the evaluation of an
            expression takes one. `accuracy` and the studies call the same function in several runs:
            a function with a memory must begin anew at the first sample of a run, where `Sample.t`
            is not greater than at the sample before.
        until
            Conditions on series of the result that end the run, by name: ``{"overload":
            ("hinge.fx", ">", 500.0)}`` or ``{"overload": "hinge.fx > 0.5 kN"}``, with "<" or ">".
            The run is made twice, first to `t_end` and then to the condition, with the values that
            `controllers` returned in the first. Conditions on positions and velocities belong in
            the scene, ``until=`` of `Model.scene`.
        correction, time_scale
            How states return onto the constraints: at every "step" (dependent coordinates from
            independent ones), at every "stage", or by "projection", "baumgarte" or "hybrid", for
            which see `runtime.integrate.problem.Options`. τ of Baumgarte's accelerations in s, by
            default a thousandth of the run.
        first_step, max_step, max_steps, max_bytes, progress
            Lengths of steps in s, chosen by default. Largest number of trial steps
            (`Outcome.MAX_STEPS`), by default 1e8, or fewer if steps become shorter and shorter.
            Largest number of bytes of recorded states (`Outcome.MEMORY`), by default 1 GiB. Whether
            a bar shows after a second.
        out
            A path ending in .zarr that does not exist yet. All quantities are written there in
            chunks during the run, and the result maps its numbers from temporary files beside it,
            so that memory does not grow with the length of the run (`max_bytes` limits events and
            changes of the partition). ``xarray.open_zarr(out)`` reads the store at any time. Its
            attribute `outcome` is RUNNING until the run has ended, and remains so if the process
            was killed; it is FAILED if an error ended the run. `out` is refused with reduced
            coordinates, `accuracy`, `until` or works, and where joints come and go.

        Returns
        -------
        Result
            Motion, reactions, powers, energies, modes, events. If the run cannot go on, the result
            ends there: see `Result.outcome` and `Result.message`.

        Raises
        ------
        InputError, ParameterError, AssemblyError
            If arguments or parameters make no sense, the start cannot be assembled, `guess`
            names what the scene fixes, or the samples need more memory than is free.
        AnalysisError
            If the scene has no masses, nothing is left to integrate, or not even the beginning can
            be computed to the given `accuracy`.

        Examples
        --------
        >>> m = lw.load("pendulum.py", scene="swing")
        >>> r = m.simulate(10.0, rtol=1e-10, parameters={"length": 1.2})
        >>> r.q("bob.phi")[-1], r.reaction("hinge", "fy").max()  # rad, N
        >>> m.simulate(10.0, np.linspace(0.0, 10.0, 1001), start={"bob.phi": 0.5})
        """
        given = locals()  # the arguments by name
        from runtime.dynamics.connected_simulation import parameters_there, scene_of_start, simulate
        from runtime.dynamics.output_conditions import read_conditions, simulate_until

        require_motion(self.mechanism, "simulate")
        mechanism = scene_of_start(self.mechanism, start)
        given = check(mechanism, given)
        given["parameters"] = parameters_there(mechanism, self.mechanism, given["parameters"])
        settings = {name: given.pop(name) for name in _SETTINGS}
        place = given.pop("out")
        if place is not None:
            from runtime.dynamics.stored_simulation import refuse_store, simulate_into

            refuse_store(mechanism, settings, until)
            given["part"] = partial(simulate_into, Path(place))
        conditions = () if until is None else read_conditions(mechanism.description, until)
        if accuracy is None and quantities is None:
            given |= {name: value for name, value in settings.items() if value is not None}
            analyse: Callable[..., Result] = partial(simulate, mechanism)
        else:
            from runtime.accuracy_target.search import simulate_to

            analyse = partial(simulate_to, mechanism, **settings)
        with bar(f"simulate {mechanism.title}", given.pop("progress")) as report:
            if until is None:
                return analyse(**given, progress=report)
            return simulate_until(analyse, conditions, {**given, "progress": report})

    @shows_compilation
    def ensemble(
        self, t_end: "float | npt.ArrayLike | None" = None,
        t_eval: "npt.ArrayLike | int | None" = None, *, analysis: str = "simulate",
        parameters: "Columns | None" = None, starts: "Columns | None" = None,
        guesses: "Columns | None" = None, t_start: float = 0.0,
        method: str | None = None, rtol: float | None = None,
        atol: float | None = None, max_step: float | None = None, max_steps: int | None = None,
        threads: int | None = None, max_bytes: int = 2**31, progress: bool = True,
    ) -> "xr.Dataset":  # fmt: skip
        """Many runs of this machine, in several threads, as rows of one dataset.

        Each run has the numbers of the single analysis with the same values, to the last bit.

        Parameters
        ----------
        t_end, t_eval, t_start, method, rtol, atol, max_step, max_steps
            As the analysis takes them, the same for all runs; no "steps".
        analysis
            "simulate", "kinematics" or "inverse_dynamics".
        parameters, starts, guesses
            Values by name, SI units or texts, ``"45 mm"``, as the `parameters`, `start` and `guess`
            of the analysis: one for all runs, or an array with one for each, (r,). At least one is
            an array.
        threads
            Number of threads, by default one for each core that the process may use; 1: the calling
            thread makes the runs.
        max_bytes, progress
            Bytes that the dataset may take, 2 GiB by default; whether a bar shows.

        Returns
        -------
        xarray.Dataset
            The variables of `Result.data`, with the dimension `run` before `time`, and nan after
            the end of a run that failed; `outcome`, `message` and `event_count` of each run. The
            outcome of a run that was refused is the name of the error, and that of a run that
            Ctrl-C left out is "not run".

        Raises
        ------
        InputError
            If names, shapes, lengths or values make no sense, joints come and go in the simulated
            scene, or the dataset would be larger than `max_bytes`.
        AnalysisError
            If the scene has no masses, or the drivers of a driven motion leave freedom whatever
            the values.

        Examples
        --------
        >>> m = lw.load("pendulum.py", scene="swing")
        >>> m.ensemble(10.0, 101, parameters={"length": np.linspace(0.5, 2.0, 1000)})
        >>> m = lw.load("four_bar", "inverse_dynamics")
        >>> many = m.ensemble(1.0, analysis="inverse_dynamics", parameters={"AB": [0.8, 1.0]})
        >>> many["reaction"].sel(joint="crank_drive", component="torque")  # N m, over run and time
        """
        given = locals()
        from runtime.sweeps.ensemble import run_ensemble
        from runtime.sweeps.ensemble_arguments import read_ensemble

        given = read_ensemble(self.mechanism, given)
        with bar(f"ensemble of {self.mechanism.title}", given.pop("progress")) as report:
            return run_ensemble(self.mechanism, **given, progress=report)

    @shows_compilation
    def kinematics(
        self, t_end: "float | npt.ArrayLike | None" = None,
        t_eval: "npt.ArrayLike | int | None" = None, *, parameters: Values | None = None,
        guess: Values | None = None, start: "Assembly | State | Result | Values | None" = None,
        t_start: float = 0.0, progress: bool = True,
    ) -> "Result":  # fmt: skip
        """Positions, velocities and accelerations of a machine whose drivers leave no freedom.

        If the machine locks up, the result has the instants before and then the position in which
        it locks, where velocities are nan; the outcome says so. At a singular configuration where
        motions cross, the result follows the branch of continuous velocity. Lock-ups and crossings
        are events; `Result.singular` describes them.

        Parameters
        ----------
        t_end, t_eval
            As for `simulate`: the last instant in s, and the output instants, increasing, or their
            number, by default 501. The output instants may also be given alone, in place of
            `t_end`: `[1.0]` is the one instant 1 s.
        parameters, guess, start
            Parameter values by name, SI units or texts, ``"45 mm"``, in place of the defaults.
            Values by name of coordinate or velocity in place of the scene's, as for `simulate`: the
            search for the start begins at `guess` and keeps `start`. Or `start` is a state, such as
            one of `assembly_modes`, on whose branch the motion begins, at its instant.
        t_start
            Instant in s to which the start values belong. The machine is assembled there and
            followed to the first output instant, so that it stays on the branch on which it starts.
        progress
            Whether a terminal shows a bar.

        Raises
        ------
        AnalysisError
            If the drivers leave degrees of freedom, if the scene has rigid contacts, or if the
            machine starts in a singular configuration and no velocities determine the branch.
        AssemblyError, InputError
            As `simulate`.

        Examples
        --------
        >>> r = lw.load("slide.py").kinematics([0.0, 0.5, 1.0])  # s
        >>> r.q("slide.x"), r.v("slide.vx"), r.a("slide.x")  # m, m/s, m/s^2
        """
        given = locals()
        from runtime.dynamics.prescribed_motion import kinematics

        return self._prescribed_motion(kinematics, given)

    @shows_compilation
    def inverse_dynamics(
        self, t_end: "float | npt.ArrayLike | None" = None,
        t_eval: "npt.ArrayLike | int | None" = None, *, parameters: Values | None = None,
        guess: Values | None = None, start: "Assembly | State | Result | Values | None" = None,
        t_start: float = 0.0, unknown: "Sequence[str] | None" = None,
        weights: "Mapping[str, float] | None" = None, progress: bool = True,
    ) -> "Result":  # fmt: skip
        """Forces and torques that a prescribed motion requires, and the reactions in the joints.

        The motion is that of `kinematics`, without a position in which the machine locks up, since
        forces have no bound there. The reaction of a driver is the force or torque that it exerts
        on the body that it moves.

        Parameters
        ----------
        t_end, t_eval, parameters, guess, start, t_start, progress
            As for `kinematics`: instants in s, values by name in their units, whether a bar shows.
        unknown
            Torques, forces of one component, line forces and motors, whose values are found in
            place of those of the drivers, which exert nothing then. At least as many as drivers.
        weights
            Weights of these by name, 1 unless given: of more than drivers, those values are found
            whose squares, with weight times value in SI units, have the least sum.

        Raises
        ------
        AnalysisError
            As `kinematics`; also if the scene has no masses, or if friction sticks, so that the
            motion does not determine its force; or if the unknown do not move what is driven.
        AssemblyError, InputError
            As `simulate`.

        Examples
        --------
        >>> r = lw.load("slide.py").inverse_dynamics([0.0, 0.5, 1.0])  # s
        >>> r.reaction("feed", "fx")  # N: what the driver exerts
        """
        given = locals()
        from runtime.dynamics.prescribed_motion import inverse_dynamics

        return self._prescribed_motion(inverse_dynamics, given)

    def _prescribed_motion(
        self, analyse: Callable[..., "Result"], given: dict[str, Any]
    ) -> "Result":
        """The motion that the drivers prescribe, analysed, with arguments by name."""
        word, t_end = analyse.__name__, given.pop("t_end")
        require_motion(self.mechanism, word)
        refuse_states(self.mechanism, word)
        given = check(self.mechanism, given)
        given["t_start"] = getattr(given["start"], "t", given["t_start"])  # of a state its own
        times = instants_of_motion(t_end, given.pop("t_eval"), given["t_start"], word)
        title = f"{word.replace('_', ' ')} of {self.mechanism.title}"
        with bar(title, given.pop("progress")) as report:
            return analyse(self.mechanism, times, **given, progress=report)

    @shows_compilation
    def equilibrium(
        self, method: str = "energy", *, guess: Values | None = None,
        parameters: Values | None = None, t: float = 0.0, progress: bool = True,
    ) -> "Equilibrium":  # fmt: skip
        """A rest position near the start, its stability, and the reactions in it.

        Parameters
        ----------
        method
            "energy": a minimum of the total potential energy; with states of first order and
            sampled values, positions and states at which all rates vanish. "settling": a damped
            motion until rest, which also succeeds from a start far from it.
        guess, parameters
            Positions and states by name, at which the search begins, in place of the scene's; the
            search may change start values of the scene. Parameter values by name. Both in SI units
            or as texts, ``"45 mm"``.
        t, progress
            Drivers and forces that depend on t have their values at this instant, s, by default at
            t = 0; whether a terminal shows a bar.

        Returns
        -------
        Equilibrium
            A result of one instant, with the stability, the natural frequencies and the unbalanced
            share of the forces. Its outcome is `Outcome.UNBALANCED` if no equilibrium was found.

        Raises
        ------
        AnalysisError
            If the scene has no masses or no degree of freedom, if it has rigid contacts or friction
            that sticks, if forces at the start are not finite, if `method` does not exist, or is
            "settling" with states, or if a sampled value is computed by a function of yours.
        AssemblyError, InputError
            As `simulate`.

        Examples
        --------
        >>> rest = lw.load("pendulum.py").equilibrium(guess={"bob.phi": -1.0})
        >>> rest["bob.phi"], rest.stable, rest.frequencies  # rad, bool, Hz
        """
        given = check(self.mechanism, locals())
        from runtime.statics.equilibrium import equilibrium

        if method == "settling":
            require_motion(self.mechanism, 'equilibrium(method="settling")')
        require_energy(self.mechanism)
        with bar(f"equilibrium of {self.mechanism.title}", given.pop("progress")) as report:
            return equilibrium(self.mechanism, **given, progress=report)
