"""A case: model, scene, values and settings of a run as data, from a file and into one."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.files.whole_files import whole_file
from codegen.object_display import html_of
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class, named_attributes
from codegen.readers.quantities import UnitError, number_in
from codegen.readers.values import shown
from runtime.cases.document import Document, Place, plain, read_document, require_ending, text_of
from runtime.cases.fields import FORMAT, analysis_of, problems_of, read_run
from runtime.core.kinds import ANALYSES
from runtime.mechanism.table_rows import unknown

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine_facade import Machine
    from runtime.results.result import Result

_VALUES = ("parameters", "start", "guess")


@readers.reads(path=readers.path)
def load_case(path: str | os.PathLike[str]) -> "Case":
    """Read a case from a file; nothing is executed, and no model is loaded.

    Parameters
    ----------
    path
        A file ending in .yaml, .yml or .json.

    Raises
    ------
    InputError
        If the file cannot be read or is no case: a sentence for each problem, with the line in a
        YAML file, the key, and the nearest keys that there are.

    Examples
    --------
    >>> case = lw.load_case("compressor_heavy.yaml")
    >>> result = case.analyse()
    """
    file = Path(path)
    case = Case.__new__(Case)
    _fill(case, read_document(file), file.resolve().parent)
    return case


@named_attributes
@checked_class
class Case:
    """Model, scene, values and settings of a run, as data.

    Values are numbers in SI units, or texts of a number and its unit, such as ``"1200 mm"``.

    Parameters
    ----------
    model
        Name of a model, or path of its file.
    scene
        Name of a scene; or a scene as data, in the words of `Model.scene` with its `name`; or a
        declared `Scene`, which becomes data. By default the model's first scene.
    analysis
        "simulate", "kinematics", "inverse_dynamics" or "equilibrium".
    parameters, start, guess
        Values by name, as the analyses take them.
    run
        Words of the analysis: ``{"t_end": 10.0, "rtol": 1e-8}``; conditions as texts:
        ``{"until": {"home": "body.x > 3"}}``.

    Raises
    ------
    InputError
        A sentence for each word that does not fit.

    Examples
    --------
    >>> case = lw.Case("pendulum.py", "swing", parameters={"length": "120 cm"}, run={"t_end": 5.0})
    >>> case.save("long.yaml")
    >>> case.analyse().q("bob.phi")
    """

    model: str
    scene: str | dict[str, Any] | None
    analysis: str
    parameters: dict[str, float | str]
    start: dict[str, float | str]
    guess: dict[str, float | str]
    run: dict[str, Any]
    _document: Document
    _folder: Path  # as seen from which the model lies

    def __init__(
        self, model: str | os.PathLike[str],
        scene: "str | Scene | Mapping[str, Any] | None" = None, *, analysis: str = "simulate",
        parameters: Mapping[str, float | str] | None = None,
        start: Mapping[str, float | str] | None = None,
        guess: Mapping[str, float | str] | None = None, run: Mapping[str, Any] | None = None,
    ) -> None:  # fmt: skip
        if hasattr(scene, "request"):
            from codegen.reading.scenes_as_data import data_of_scene

            scene = data_of_scene(scene)  # type: ignore[arg-type]
        given = {
            "model": model, "scene": scene, "analysis": analysis, "parameters": parameters,
            "start": start, "guess": guess, "run": run,
        }  # fmt: skip
        content = {name: value for name, value in given.items() if value is not None}
        _fill(self, Document(plain(content)), Path.cwd())

    @property
    def data(self) -> dict[str, Any]:
        """The case as nested mappings, lists, numbers and texts, as a file has them."""
        names = ("scene", "analysis", *_VALUES, "run")
        usual = {"scene": None, "analysis": ANALYSES[0]}
        given = {
            word: plain(of) for word in names if (of := vars(self)[word]) != usual.get(word, {})
        }
        return {"format": FORMAT, "model": self.model, **given}

    @readers.reads(path=readers.path)
    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the case into a file, whole or not at all; numbers keep all their bits.

        Parameters
        ----------
        path
            Ending in .yaml, .yml or .json; replaces an older one. The path of a model file is
            written relative to this file's folder.

        Raises
        ------
        InputError
            If the ending is another one, or the file cannot be written.
        """
        file = Path(path)
        require_ending(file)
        content = self.data
        if _is_path(self.model) and not Path(self.model).is_absolute():
            there = os.path.relpath(self._folder / self.model, file.resolve().parent)
            content["model"] = Path(there).as_posix()
        text = text_of(content, file)
        with whole_file(file) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
        return file

    @property
    def path(self) -> Path | None:
        """The file from which the case was read; None for a case made in Python."""
        return self._document.file

    @property
    def model_path(self) -> str:
        """The model as `load` takes it: a name, or the path of its file."""
        return str(self._folder / self.model) if _is_path(self.model) else self.model

    def source(self) -> "tuple[str | Model, str | Scene | None]":
        """The model and the scene, as `load` takes them.

        A scene as data is declared in the model, whose file is executed for that.
        """
        if not isinstance(self.scene, dict):
            return self.model_path, self.scene
        from codegen.reading.scenes_as_data import scene_of_data

        try:
            return scene_of_data(self.model_path, plain(self.scene))
        except InputError as error:
            error.locate(self._document.place(("scene",)))
            raise

    def machine(self, *, generated: str | os.PathLike[str] | None = None) -> "Machine":
        """The machine of the case; its model file is Python and is executed where need be.

        Parameters
        ----------
        generated
            The folder of the generated modules, as for `load`. Those of a scene as data lie in
            `.linkwright_cache`.

        Raises
        ------
        InputError
            As `load`; if the scene does not fit the model.
        """
        from runtime.machine_loading import load
        from runtime.studies.harness import cache_folder

        model, scene = self.source()
        if isinstance(self.scene, dict):
            return load(model, scene, folder=cache_folder(None))
        return load(model, scene, generated=generated)

    def words(self, machine: "Machine") -> dict[str, Any]:
        """The arguments of the analysis, numbers in the units of the machine.

        Raises
        ------
        InputError
            A sentence for each name that the machine does not have, and each unit that does not
            fit.
        """
        about, problems, found = machine.description, list[str](), dict[str, Any]()
        parameters = {row.name: row.unit for row in about.parameters}
        parameters |= dict.fromkeys(about.unused, "")
        states = {name: about.series.find(name).unit for name in about.startable}
        for word in _VALUES:
            units = parameters if word == "parameters" else states
            numbers = dict[str, float]()
            for name, value in vars(self)[word].items():
                try:
                    unit = units[name]
                    text = isinstance(value, str)
                    numbers[name] = number_in(value, unit) if text else float(value)
                except KeyError:
                    what = "parameter" if units is parameters else "coordinate, velocity or state"
                    problems.append(self._problem((word, name), unknown(what, name, units)))
                except UnitError as error:
                    problems.append(self._problem((word, name), str(error)))
            found |= {word: numbers} if vars(self)[word] else {}
        if self.analysis == "equilibrium" and found.pop("start", None):
            why = "an equilibrium has no start values; give them as guess."
            problems.append(self._problem(("start",), why))
        found |= read_run(self.analysis, self.run)
        for name, condition in found.get("until", {}).items():
            row = about.series.get(condition.series)
            try:
                value = number_in(condition.value, row.unit if row else "")
                found["until"][name] = condition.series, condition.sign, value
            except UnitError as error:
                problems.append(self._problem(("run", "until", name), str(error)))
        if problems:
            raise InputError(problems)
        return found

    def _problem(self, at: Place, why: str) -> str:
        return self._document.problem(at, why)

    def analyse(self, **words: Any) -> "Result":
        """Load the machine and make the analysis.

        Parameters
        ----------
        words
            Words of the analysis in place of those of the case, such as ``t_end=20.0``.

        Raises
        ------
        InputError
            As `machine`, `words` and the analysis.
        """
        machine = self.machine()
        given = self.words(machine) | words
        if self.analysis == "simulate" and "t_end" not in given:
            why = "t_end is missing: the last instant in s."
            raise InputError(self._problem(("run",), why))
        result: Result = getattr(machine, self.analysis)(**given)
        return result

    def __repr__(self) -> str:
        """The case as its YAML or JSON has it."""
        return (
            f"Case({', '.join(f'{k}={shown(v)}' for k, v in self.data.items() if k != 'format')})"
        )

    def _repr_html_(self) -> str:
        """The case for notebooks."""
        return html_of("\n".join(f"{k}: {shown(v)}" for k, v in self.data.items()))


def _fill(case: Case, document: Document, folder: Path) -> None:
    """Check the data of a case, and give them to it."""
    if problems := problems_of(document):
        raise InputError(problems)
    data = document.data
    vars(case).update(
        model=data["model"], scene=data.get("scene"), analysis=analysis_of(data),
        **{word: data.get(word, {}) for word in (*_VALUES, "run")},
        _document=document, _folder=folder,
    )  # fmt: skip


def _is_path(model: str) -> bool:
    """Whether a model is the path of its file, and no name."""
    return model.endswith(".py") or Path(model).is_absolute()
