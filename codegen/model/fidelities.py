"""Fidelities: an element is declared once; each scene takes it as finely as its question needs."""

from collections.abc import Iterable, Mapping
from typing import Any

from codegen.declare.element import Effect
from codegen.declare.scene import Scene, name_of
from codegen.declare.value_reader import Reader
from codegen.model.bodies import FORMS, Bodies
from codegen.readers.values import nearest, shown

NONE = "none"  # the fidelity of an effect that a scene does without


class Fidelities(Bodies):
    """Effects with several laws, couplers, and groups of alternatives."""

    def alternatives(
        self, name: str, choices: Mapping[str, Iterable[Any]], default: str | None = None
    ) -> str:
        """Elements that stand for one another, of which a scene takes one choice; returns `name`.

        A cam's follower that is held to the cam or may leave it, a spring of six masses or of
        fifty: each choice names the bodies, joints, effects and drivers that only it has. In a
        scene with ``fidelity={name: choice}`` its effects and drivers act, and nothing of the other
        choices takes part. A scene that says nothing has the default's bodies and joints.

        Parameters
        ----------
        choices
            Choice, a word → elements, by name or by the objects that their declarations returned.
        default
            The first choice unless given.
        """
        where = f"alternatives '{name}'"
        known = self.elements
        read: dict[str, tuple[str, ...]] = {}
        like = "{'held': ['joint'], 'free': ['contact']}"
        for choice, elements in self._read.mapping(choices, "choices", like, where).items():
            if not isinstance(choice, str):
                self._note(f"{where}: choice {shown(choice)} is no word.")
            word = str(choice)
            names = self._read.names(elements, "elements", f"{where}, {word}", known)
            for missing in (n for n in names if n not in known):
                self._note(f"{where}, {word}: there is no '{missing}'; {nearest(missing, known)}")
            read[word] = tuple(n for n in names if n in known)
        if len(read) < 2:
            self._note(f"{where}: {len(read)} choice is no choice; give at least two.")
        if default is not None and str(default) not in read:
            self._note(f"{where}: no choice {shown(default)}; {nearest(str(default), read)}")
            default = None
        if self._claim("group of alternatives", name) and read:
            chosen = default or next(iter(read))
            self.groups[name] = {chosen: read[chosen]} | read
        return name

    def acting(self, scene: Scene) -> dict[str, Effect]:
        """Name → the effects of a scene, in the fidelity that it asks for, and rates of states."""
        how = dict(scene.fidelity)
        effects = {}
        for name in scene.effects:
            form = self.fidelities.get(name, {}).get(how.get(name, ""))
            effects[name] = self.effects[name] if form is None or isinstance(form, str) else form
        return effects | {name: self.states[name].effect for name in scene.states}

    def _read_fidelities(
        self, read: Reader, where: str, fidelity: Any, couplers: Any
    ) -> tuple[tuple[str, str], ...]:
        """The fidelities that a scene names; impossible ones are noted as problems."""
        fidelities: dict[str, str] = {}
        for key, form in read.mapping(couplers, "couplers", "{'rod': 'link'}", where).items():
            name = name_of(key)
            if name in self.couplers:
                fidelities[name] = read.choice(form, FORMS, f"{where}, coupler '{name}'")
            else:
                read.note(f"{where}: there is no coupler '{name}'; {nearest(name, self.couplers)}")
        for key, word in read.mapping(fidelity, "fidelity", "{'rub': 'sticking'}", where).items():
            name = name_of(key)
            if problem := self._fidelity_problem(name, word, fidelities.get(name, word)):
                read.note(f"{where}: {problem}")
            else:
                fidelities[name] = word
        return tuple(fidelities.items())

    def _fidelity_problem(self, name: str, word: Any, named: Any) -> str | None:
        """Why an element cannot be taken as `word`; `named`: its form among the couplers."""
        if not isinstance(word, str):
            return (
                f"'{name}' with the fidelity {shown(word)}; a scene takes one at a time: "
                "give one word, or declare a scene for each."
            )
        if named != word:
            return f"'{name}' is asked for as '{named}' and as '{word}'; give one fidelity."
        if name in self.couplers:
            choices: Mapping[str, Any] = dict.fromkeys(FORMS)
        elif name in self.groups:
            choices = self.groups[name]
        elif name in self.effects:
            choices = self.fidelities.get(name, {}) | {NONE: ()}
            if len(choices) == 1 and word != NONE:
                return (
                    f"{self.effects[name].kind} '{name}' has one fidelity only, so it cannot be "
                    f"taken as '{word}'; leave fidelity= out."
                )
        else:
            hint = nearest(name, self.fidelities | self.groups | dict.fromkeys(self.couplers))
            return f"nothing called '{name}' has fidelities; {hint}"
        if word not in choices:
            return f"'{name}' cannot be taken as '{word}'; {nearest(word, choices)}"
        lacking = choices[word]
        return f"'{name}' as '{word}' {lacking}" if isinstance(lacking, str) else None

    def choice(self, group: str, how: Mapping[str, str], effects: Iterable[str]) -> str:
        """The alternative of a scene, by its fidelities `how` or by the effects that it names."""
        choices = self.groups[group]
        named = [word for word, names in choices.items() if {*effects}.intersection(names)]
        return how.get(group) or (named[0] if len(named) == 1 else next(iter(choices)))

    def _group_members(
        self, read: Reader, where: str, how: dict[str, str], effects: tuple[str, ...]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Elements that the choices of groups bring, and those that they leave out."""
        included: list[str] = []
        excluded: list[str] = []
        for group, choices in self.groups.items():
            choice = self.choice(group, how, effects)
            members = choices[choice]
            others = [n for names in choices.values() for n in names if n not in members]
            if clash := [n for n in others if n in effects]:
                read.note(
                    f"{where}: '{clash[0]}' acts only in another choice of '{group}' than "
                    f"'{choice}', which the scene takes; give fidelity={{'{group}': ...}} and "
                    "leave the other's effects out."
                )
            included += members if group in how else ()
            excluded += others
        return tuple(included), tuple(excluded)
