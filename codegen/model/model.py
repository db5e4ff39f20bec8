"""The declaration of a machine: bodies, parameters, joints, drivers, effects and scenes.

A declaration never raises for a wrong element: every problem is noted, and `build` reports all
of them at once (`codegen.check.declaration`).
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect, label
from codegen.declare.returned_values import check_parts, named
from codegen.declare.scene import Scene
from codegen.declare.space_body import SpaceBody
from codegen.elements.registry import ACTIONS
from codegen.errors import ModelError, NoAttributeError
from codegen.model.base import Declared
from codegen.model.contacts import Contacts
from codegen.model.forces import Forces
from codegen.model.scenes import Scenes
from codegen.model.values import Values
from codegen.object_display import html_of, html_table
from codegen.presentation import VIEWS, in_pyplot
from codegen.readers import arguments as readers
from codegen.readers.calls import declaring, named_attributes
from codegen.readers.values import one_line, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from codegen import SceneEquations


_INNER = (
    *("acting", "altered", "choice", "defaults", "effects_alone", "elements", "files", "in_space"),
    *("kind", "labels", "noted", "place_of", "recompose", "reconnected", "symbols", "together"),
    *("token", "unit_of", "varied", "watched"),
)
"""Public words of a model that declare nothing: those who derive and build it read them."""
_SYNONYMS = {
    "body": "rigid_body part link rod",
    "revolute": "hinge pin pivot bearing joint",
    "spherical": "ball socket ball_and_socket rod_end joint",
    "translational": "slider prismatic guide piston linear joint",
    "universal": "cardan hooke u",
    "weld": "fix fixed clamp rigid bolt",
    "distance": "rod link tie_rod pitch_rod rope cable wire",
    "revolute_revolute": "link rod",
    "gear": "bevel bevel_gear differential planetary",
    "rack_and_pinion": "rack pinion",
    "spring": "damper spring_damper dashpot shock_absorber",
    "rotation_driver": "actuator drive servo",
    "translation_driver": "actuator drive",
    "track": "point marker",
}
"""Method of a model → words for it elsewhere."""


@named_attributes
class Model(Values, Scenes, Forces, Contacts):
    """A machine, in the plane or in space.

    Parameters
    ----------
    name
        Begins the names of the generated files. Like every `name` that the methods take it is an
        identifier: ASCII letters, digits and underscores, a letter first.
    gravity
        (g_x, g_y) in m/s², in space (g_x, g_y, g_z); declares the effect ``"gravity"``. Other
        gravities: `Model.gravity`.
    space
        Whether the machine moves in space: bodies have Euler parameters, and points, axes and
        forces three numbers. The methods have the same names; ``help(lw.SpaceModel)`` shows them.

    Examples
    --------
    >>> model = Model("pendulum", gravity=(0, -9.81))
    >>> bob = model.body("bob", mass=1.0, inertia=0.1)
    >>> hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    >>> swing = model.scene("swing", effects=["gravity"], start={"bob.phi": 0})
    """

    _unlisted: tuple[str, ...] = _INNER
    _synonyms = _SYNONYMS

    def __new__(cls, *_: Any, space: Any = False, **__: Any) -> "Model":
        """A machine in space where `space` says so."""
        if space is True and cls is Model:
            from codegen.model.space_model import SpaceModel

            return super().__new__(SpaceModel)
        return super().__new__(cls)

    @declaring("Model")
    def __init__(
        self, name: str, gravity: tuple[Any, ...] | None = None, *, space: bool = False
    ) -> None:
        super().__init__(name)
        if space is not False and space is not self.in_space:
            self._note(f"model '{name}': space={shown(space)}; write True or False.")
        if gravity is not None:
            self.gravity("gravity", gravity)

    def __setattr__(self, word: str, value: object) -> None:
        """Refuse ``model.gravity = (0, -9.81)`` and other words, as nothing would read them."""
        is_inner = word.startswith("_") or word in ("files", "noted") or "_kinds" not in vars(self)
        if not is_inner and (type(self) is Model or hasattr(self, word)):
            raise NoAttributeError(
                f"model '{self.name}': '{one_line(word)}' cannot be set; declare with the methods "
                "of the model, and a machine of another name as another model."
            )
        super().__setattr__(word, value)

    def __str__(self) -> str:
        """The name, then what is declared, a line a kind."""
        rows: dict[str, Iterable[str]] = {
            "bodies": self.bodies, "states": self.states, "joints": self.joints,
            "drivers": self.drivers, "effects": [e for e in self.effects if e not in self.points],
            "points": [e for e in self.effects if e in self.points], "scenes": self.scenes,
        }  # fmt: skip
        texts = {word: ", ".join(names) for word, names in rows.items()}
        lines = [f"{word} {text}" for word, text in texts.items() if text]
        return "\n".join((f"Model {self.name!r}", *lines))

    def _repr_html_(self) -> str:
        """What is declared, with a table of the parameters, for notebooks."""
        values = ((p.name, p.value, p.unit) for p in self.parameters.values())
        return html_of(str(self), html_table(("parameter", "default", "unit"), values))

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """What is declared, for the prompt of IPython."""
        printer.text(repr(self) if cycle else str(self))

    @in_pyplot()
    @readers.reads(
        scene=readers.optional(readers.scene),
        parameters=readers.optional(readers.values('{"L": 1.2}')), assembled=readers.flag,
        **dict.fromkeys(("dimensions", "forces", "frames", "names"), readers.flag),
        view=readers.word(*VIEWS),
    )  # fmt: skip
    def draw(
        self, scene: "str | Scene | None" = None, *,
        parameters: "Mapping[str, float | str] | None" = None, assembled: bool = True,
        dimensions: bool = False, forces: bool = False, frames: bool = False, names: bool = True,
        view: str = "usual",
    ) -> "Figure":  # fmt: skip
        """Draw the machine as it is declared, before anything is built.

        Parameters
        ----------
        scene
            Name of a scene, or a `Scene`; by default the first. Its joints, drivers and effects
            are drawn.
        parameters
            Values by name, in SI units or as texts, ``"45 mm"``, in place of the defaults.
        assembled
            Whether the joints are closed first, as for a run. With False, or if a warning says that
            they cannot be closed, the machine is drawn at its guesses, and a dashed line shows how
            far each joint is open.
        dimensions, forces, frames, names
            Whether to draw the distances between the points of a body, m; the applied forces, to
            scale; the frames x'-y' and centres of mass; the names of bodies and joints.
        view
            In space ``"x"``, ``"y"`` or ``"z"``, along an axis from its positive side; ``"-x"`` …
            from the other.

        Returns
        -------
        Figure
            Of Matplotlib; ``figure.savefig("machine.svg")`` saves it.

        Raises
        ------
        ModelError
            With all problems of the declaration at once.
        InputError
            If an argument is of the wrong kind, or Matplotlib is not installed.
        """
        from codegen import declared_picture  # which the package loads now: it imports models
        from codegen.drawing.matplotlib_painter import figure

        picture = declared_picture(self, scene, parameters, assembled)
        return figure(picture, dimensions, forces, frames=frames, names=names, view=view)

    @readers.reads(scene=readers.optional(readers.scene))
    def equations(self, scene: "str | Scene | None" = None) -> "SceneEquations":
        """M, Φ, Φ_q, ν, γ and Q of a scene as matrices of SymPy, with their names.

        Parameters
        ----------
        scene
            Name of a scene, or a `Scene`; by default the first.

        Returns
        -------
        SceneEquations
            Which a notebook shows; its matrices are attributes.

        Raises
        ------
        ModelError, SceneError
            With all problems of the declaration.
        """
        from codegen import scene_equations

        return scene_equations(self, scene)

    def add(self, element: Declared) -> Declared:
        """Declare a user-defined element: a `Constraint`, an `Effect` or a kind of `Body`.

        A body takes ``model.token`` as its `model`.
        """
        candidate: object = element
        with named(element, "bodies"):
            is_known = isinstance(candidate, Body | Constraint | Effect)
        if not is_known:
            self._note(
                f"model.add({shown(element)}): neither a Body, a Constraint nor an Effect; it "
                "needs kind, name, bodies, problems(), and statement() or potential() and forces()."
            )
            return element
        if isinstance(candidate, Body) and isinstance(candidate, SpaceBody) is not self.in_space:
            self._note(f"{label(element)}: the bodies of a model are all in the plane or in space.")
            return element
        kind: Any = type(element)
        own = (a for a in ACTIONS if getattr(kind, a, None) is not getattr(Effect, a, None))
        if Effect in kind.__mro__ and not any(own):
            self._note(f"{label(element)} has none of {', '.join(ACTIONS)}; write one.")
        try:
            check_parts(element)
        except ModelError as error:
            self._read.problems += error.problems
            return element
        return self._declare(element)
