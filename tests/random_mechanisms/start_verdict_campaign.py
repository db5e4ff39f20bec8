"""Whether linkages assemble, by everything that says so: `python -m ... 0 500`.

`check`, `draw`, `build`, `load`, `assemble` and the analyses of a scene agree, and a linkage that
cannot close is refused.
"""

import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from codegen import build, declared_picture
from codegen.errors import AssemblyError
from codegen.explain.declaration_report import check_declaration
from runtime import load
from tests.random_mechanisms.linkages import Linkage, random_linkage
from tests.random_mechanisms.seed_range import run_campaign


def verdicts(linkage: Linkage, folder: Path) -> dict[str, bool]:
    """Each that says whether a linkage assembles → whether it does."""
    model = linkage.model
    with warnings.catch_warnings(record=True) as noted:
        warnings.simplefilter("always")
        found = {
            "check": not check_declaration(model).problems,
            "draw": "do not close" not in declared_picture(model).title,
            "build": not any(scene.problem for scene in build(model, out=folder).scenes),
        }
        noted.clear()
        machine = load(model, folder=folder)
    found["load"] = not any(str(w.message).startswith(machine.mechanism.title) for w in noted)
    analyses: dict[str, Callable[[], Any]] = {"assemble": machine.assemble}
    if linkage.drive == "none":
        analyses["simulate"] = lambda: machine.simulate(1e-3, progress=False)
        analyses["equilibrium"] = lambda: machine.equilibrium(progress=False)
    else:
        analyses["kinematics"] = lambda: machine.kinematics([0.0], progress=False)
        analyses["inverse dynamics"] = lambda: machine.inverse_dynamics([0.0], progress=False)
    return found | {name: not _is_refused(analyse) for name, analyse in analyses.items()}


def _is_refused(analyse: Callable[[], Any]) -> bool:
    try:
        analyse()
    except AssemblyError:
        return True
    return False


def judge(seed: int) -> tuple[list[str], str]:
    """What is wrong with the verdicts on a linkage, and a word about it."""
    linkage = random_linkage(seed)
    with tempfile.TemporaryDirectory() as folder:
        found = verdicts(linkage, Path(folder))
    complaints = [] if len({*found.values()}) == 1 else [f"verdicts {found}"]
    if found["assemble"] and not linkage.closes:
        complaints.append("what cannot close is assembled")
    word = "assembled" if found["assemble"] else "refused"
    truth = "closes" if linkage.closes else "cannot close"
    return complaints, f", {word}; {linkage.kind}, {linkage.drive}, {truth}"


if __name__ == "__main__":
    run_campaign(__doc__, judge)
