"""Scenes in which a run goes on once other joints act, found beside the scene's module or built."""

from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import AnalysisError
from codegen.files.generated_modules import (
    check_signature,
    import_generated,
    read_generated,
    text_hash,
)
from runtime.core.kernel_abi import gather
from runtime.mechanism.companion_modules import Origin
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import describe
from runtime.mechanism.table_rows import Watched

if TYPE_CHECKING:
    from codegen import Scene


def sibling(mechanism: Mechanism, watched: Watched) -> Mechanism:
    """The mechanism with the joints that act behind a condition of WATCHED."""
    known = mechanism.siblings
    if watched.scene not in known:
        found = _built(mechanism, watched)
        known[watched.scene] = found
        found.__dict__["siblings"] = known  # which all of them share
    return known[watched.scene]


def sibling_named(mechanism: Mechanism, scene: str) -> Mechanism | None:
    """The mechanism, or one into which it may turn as joints come and go, by its scene's name."""
    own = mechanism.description.scene
    if scene == own or _root(scene) != _root(own):
        return mechanism if scene == own else None
    found, names = [mechanism], {own}
    for known in found:  # which grows meanwhile
        ways = [row for row in known.description.watched if row.reconnects]
        for watched in ways:  # before any other sibling is built
            if watched.scene == scene:
                return sibling(known, watched)
        for watched in ways:
            if watched.scene not in names:
                names.add(watched.scene)
                found.append(sibling(known, watched))
    return None


def _root(scene: str) -> str:
    """What the names of all siblings begin with."""
    return scene.partition("_without_")[0].partition("_with_")[0]


def _built(mechanism: Mechanism, watched: Watched) -> Mechanism:
    """The sibling's module, loaded where it is there and of the same sources, else built."""
    origin, scene = mechanism.origin, watched.scene
    if origin is None:
        raise AnalysisError(
            f"{mechanism.title} was put together without its model, so scene '{scene}', in which "
            f"the run goes on, cannot be found. Load it by linkwright.load."
        )
    own = origin.path.stem.partition("__")[0]
    place = origin.path.with_name(f"{own}__{scene}.py")
    if isinstance(origin.model, Path) and isinstance(origin.scene, str) and place.is_file():
        text = read_generated(place)
        check_signature(place, text, f"linkwright build {origin.model} --scene {scene}")
        found = _mechanism(place, text_hash(text), origin, scene)
        same = ("generator", "sources")
        if all(getattr(found.description, n) == getattr(mechanism.description, n) for n in same):
            return found
    from codegen import build

    wanted: str | Scene = scene
    if not isinstance(origin.scene, str):
        owner = origin.scene.owner
        assert owner is not None
        after = {*origin.scene.connected} ^ {watched.target}
        wanted = owner.reconnected(origin.scene, tuple(after))
    (report,) = build(origin.model, wanted, origin.path.parent, compile=False).scenes
    return _mechanism(report.path, report.digest, origin, wanted)


def _mechanism(path: Path, digest: str, origin: Origin, scene: object) -> Mechanism:
    module = import_generated(path, digest)
    home = Origin(origin.model, scene, path, digest)  # type: ignore[arg-type]
    return Mechanism(describe(module), gather(module), path, home)
