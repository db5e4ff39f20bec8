"""The explicit integration methods of the runtime, written from their tableaus."""

from pathlib import Path

from codegen.emit.runge_kutta import module_text
from codegen.generated_files.generated_file import is_current, write_if_changed
from codegen.model_file import library_folder
from codegen.tableaus import tableaus

FOLDER = "generated/methods"


def write_methods(
    folder: Path | None = None, *, check: bool = False
) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Write one module a tableau; returns all paths, and those that were missing, old or of none.

    Parameters
    ----------
    folder
        Where they are put; the library's own unless given.
    check
        Write nothing.
    """
    folder = folder or library_folder() / FOLDER
    texts = {
        folder / f"{name}.py": module_text(name, tableau) for name, tableau in tableaus().items()
    }
    stale = [path for path, text in texts.items() if not is_current(path, text)]
    for path in () if check else stale:
        write_if_changed(path, texts[path])
    stale += [path for path in sorted(folder.glob("[!_]*.py")) if path not in texts]
    return tuple(texts), tuple(stale)
