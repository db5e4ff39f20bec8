"""Cache files cut short at random: `python -m tests.robustness.truncated_caches [TRIES]`.

Machine code (.nbi, .nbc) and byte code (.pyc) of the runtime, the compiler and a generated module
are cut to random lengths. The next process makes them anew, with a note, and gives the same result.
"""

import random
from pathlib import Path

from tests.robustness.command_line import FOREIGN, ROOT, Findings, Workplace, main

COMMAND = (
    *("runtime", "simulate", "rods", "--scene", "free", "--t-end", "1", "--points", "11"),
    *("--out", "result.csv"),
)
EACH = 5  # files that are cut before a process starts


def campaign(place: Workplace, tries: int, seed: int) -> Findings:
    """Cut files by their ending, and what was wrong; a process for every `EACH` of them."""
    place.found = Findings.none()
    chance, (kinds, faults) = random.Random(seed), place.found
    place.run(*COMMAND)
    first = place.run(*COMMAND)
    result = place.folder / "result.csv"
    expected = result.read_bytes()
    if first.status or "note:" in first.output:
        faults.append(f"undamaged caches: status {first.status}, {first.output}")
    while kinds.total() < tries:
        found = sorted(_files(place))
        ending = chance.choice([".nbi", ".nbc", ".pyc"])
        cut = [path for path in found if path.suffix == ending]
        cut = chance.sample(cut, min(EACH, tries - kinds.total(), len(cut)))
        for path in cut:
            content = path.read_bytes()
            path.write_bytes(content[: chance.randrange(len(content))])
        names = ", ".join(f"{path.name} ({path.stat().st_size} bytes)" for path in cut)
        kinds[ending] += len(cut)
        result.unlink()
        end = place.run(*COMMAND)
        if end.status or not result.exists() or any(word in end.output for word in FOREIGN):
            faults.append(f"{names}: status {end.status}, {end.output[-1000:]}")
        elif result.read_bytes() != expected:
            faults.append(f"{names}: another result")
        if not result.exists():
            result.write_bytes(expected)
    return place.found


def _files(place: Workplace) -> list[Path]:
    """Caches with machine code, and byte code of our own packages."""
    ours = place.byte_code.joinpath(*ROOT.parts[1:])
    folders = [ours / name for name in ("codegen", "runtime")]
    return [
        *place.code.rglob("*.nb[ic]"),
        *(path for folder in folders for path in folder.rglob("*.pyc")),
    ]


if __name__ == "__main__":
    main(__doc__, campaign)
