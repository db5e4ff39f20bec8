"""The explicit integration methods of the runtime, written from their tableaus."""

from pathlib import Path

from codegen.emit.runge_kutta import module_text
from codegen.files.library_folders import methods_folder
from codegen.generated_files.generated_file import Written, write_folder
from codegen.tableaus import tableaus


def write_methods(folder: Path | None = None, *, check: bool = False) -> Written:
    """Write one module a tableau into the library's folder, or into another; as `write_folder`."""
    folder = folder or methods_folder()
    texts = {f"{name}.py": module_text(name, tableau) for name, tableau in tableaus().items()}
    return write_folder(folder, texts, others="[!_]*.py", check=check)
