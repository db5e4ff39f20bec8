"""The source of a loaded machine, by which another process can load it too."""

import pickle
import re
from collections.abc import Mapping
from importlib import import_module, util
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from codegen.files.build_records import of_this_generator
from codegen.files.generated_modules import (
    check_signature,
    companion_path,
    read_generated,
    text_hash,
)

if TYPE_CHECKING:
    from codegen import Model, Scene

Kind = Literal["tangents", "reduced", "picture", "outputs"]

_BELONGS = re.compile(r'^MODULE_SHA256 = "([0-9a-f]{64})"$', re.MULTILINE)
CONTENTS: dict[Kind, str] = {
    "tangents": "derivatives", "reduced": "reduced equations", "picture": "picture",
    "outputs": "outputs that it does not name",
}  # fmt: skip


class Origin(NamedTuple):
    """The source of a loaded machine."""

    # the model file, or the `Model` of the running program; of another program this and the scene,
    # pickled
    model: "Path | Model | bytes"
    scene: "str | Scene"
    path: Path  # the scene's generated file
    text: str  # which it had
    companions: Mapping[str, str] = {}  # their texts, of a machine that was pickled

    @property
    def digest(self) -> str:
        """SHA-256 of the text."""
        return text_hash(self.text)

    def current_companion(self, kind: Kind) -> str | None:
        """The text of a companion's file, where it belongs to the scene's; else None.

        Raises GeneratedFileError if the file was edited by hand.
        """
        place = companion_path(self.path, kind)
        if kind in self.companions or not place.is_file():
            return self.companions.get(kind)
        text = read_generated(place)
        belongs = _BELONGS.search(text)
        if belongs is None or belongs.group(1) != self.digest:
            return None
        check_signature(place, text, self.command(kind))
        return text if of_this_generator(place, text) else None

    def portable(self) -> "Origin":
        """As another process takes it, with the texts of its companions."""
        if isinstance(self.model, bytes):
            return self
        others = {kind: self.current_companion(kind) for kind in CONTENTS}
        found = self._replace(companions={kind: text for kind, text in others.items() if text})
        if not isinstance(self.model, Path) or not isinstance(self.scene, str):
            library = "cloudpickle" if util.find_spec("cloudpickle") else "pickle"
            try:
                source = import_module(library).dumps((self.model, self.scene))
            except Exception:  # of a user's own object in the declaration
                source = pickle.dumps((None, None))
            name = self.scene if isinstance(self.scene, str) else self.scene.name
            found = found._replace(model=source, scene=name)
        return found

    def command(self, kind: Kind) -> str:
        """How the user has a companion built anew."""
        commanded = kind in ("tangents", "reduced")
        if not (commanded and isinstance(self.model, Path) and isinstance(self.scene, str)):
            return f"delete the file, and ask for the {CONTENTS[kind]} again."
        place = self.path.parent
        return f"linkwright build {self.model} --scene {self.scene} --out {place} --{kind}"
