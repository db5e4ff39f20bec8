"""Builds the library's machines, and keeps the SHA-256 of each text in generated/SHA256SUMS.

python docs/make_checksums.py [--check] MODEL.py...

The texts of most machines are not checked in; their checksums stand for them. Scenes whose
derivatives are listed are built with these. With --check the list stays as it is, and every name
whose text differs from it is printed.
"""

import sys
from pathlib import Path

from codegen import build
from codegen.reading.model_file import read_model

ROOT = Path(__file__).resolve().parent.parent
SUMS = ROOT / "generated" / "SHA256SUMS"


def listed() -> dict[str, str]:
    """File name → SHA-256, as `sha256sum` writes them."""
    lines = SUMS.read_text(encoding="utf-8").splitlines() if SUMS.is_file() else []
    return {name: digest for digest, name in (line.split("  ") for line in lines)}


def built(path: Path, derivatives: set[str]) -> dict[str, str]:
    """File name → SHA-256 of the texts of a model; `derivatives` names the files of tangents."""
    scenes = {True: list[str](), False: list[str]()}
    for name in read_model(path).model.scenes:
        scenes[f"{path.stem}__{name}__tangents.py" in derivatives].append(name)
    digests = {}
    for tangents, names in scenes.items():
        report = build(path, names, tangents=tangents, compile=False) if names else None
        for scene in report.scenes if report else ():
            files = [scene, scene.tangents] if tangents and scene.tangents else [scene]
            digests |= {file.path.name: file.digest for file in files}
    return digests


def main() -> int:
    """Build the models and write the checksums, or with --check compare; the exit status."""
    check, before = "--check" in sys.argv, listed()
    now: dict[str, str] = {}
    for argument in sys.argv[1:]:
        if argument != "--check":
            now |= built(Path(argument), set(before))
    lines = [f"{digest}  {name}\n" for name, digest in sorted(now.items())]
    if not check:
        SUMS.write_text("".join(lines), encoding="utf-8")
    stale = [name for name in sorted({*before, *now}) if before.get(name) != now.get(name)]
    for name in stale if check else ():
        print(f"generated/{name} differs from generated/SHA256SUMS; run: make build")
    return int(check and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
