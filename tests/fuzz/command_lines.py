"""Command lines with words of the wrong kind, from a seed.

A command gets arguments and options at random, most of them nonsense. It must
end with the status 0, 1 or 2, in sentences, soon; what Python itself would say is never one.
"""

import os
from contextlib import chdir
from pathlib import Path
from random import Random
from typing import Any

from typer.main import get_command
from typer.testing import CliRunner

from linkwright.cli.application import app
from tests.fuzz import model_files

COMMANDS: dict[str, Any] = {**vars(get_command(app))["commands"]}
del COMMANDS["precompile"]  # which compiles for minutes
GOOD = {
    "model": "sound.py", "scene": "swing", "t_end": "0.1", "points": "5", "rtol": "1e-6",
    "settings": "length=2", "quantity": "range:bob.phi", "out": "out.csv",
}  # fmt: skip
"""Parameter → a word that means something for it."""
WORDS = [
    *("", "-", "--", "--help", "-1", "0", "5", "1e400", "nan", "-inf", "1_000", "１", "1,5", "abc"),
    *("None", "nowhere", "a\nb", "[red]x[/red]", "x" * 300, "\u202e", "\udcff", "%s", "{}", "="),
    *("/", ".", "..", "../x", "/dev/null", "/proc/self/mem", "folder.py", "loop.py", "empty.py"),
    *("raises.py", "bytes.py", "sound.py", "sound", "length=", "=2", "length=nan", "length=a=b"),
    *("zz=1", "bob.phi=1", "bob.phi", "out.html", "out.xyz", "folder.py/a.nc", "sound.py/a.csv"),
    *("swing", "driven", "Swing", "range:", "max:bob", "::", "radau5", "reduced", "gear", "Gear "),
]
WRITES = ("/", ".", "..", "../x")  # never where files are written
RARELY = 0.15


def prepare() -> None:
    """The files of a campaign, in a folder of its own."""
    folder = _folder()
    (folder / "folder.py").mkdir(exist_ok=True)
    if not (folder / "loop.py").is_symlink():
        (folder / "loop.py").symlink_to("loop.py")
    (folder / "sound.py").write_text(model_files.SOUND)
    (folder / "empty.py").write_text("")
    (folder / "raises.py").write_text(model_files.SOUND + "model.pin('p', bob, rod)\n")
    (folder / "bytes.py").write_bytes(b"x = '\xe9'\n")


def _folder() -> Path:
    folder = model_files.folder() / "command_lines"
    folder.mkdir(exist_ok=True)
    return folder


def line(draw: Random) -> list[str]:
    """The words of a command line."""
    command = draw.choice([*COMMANDS])
    words = [command if draw.random() < 0.97 else draw.choice(WORDS)]
    for parameter in COMMANDS[command].params:
        writes = parameter.name == "out"
        word = draw.choice([w for w in WORDS if not (writes and w in WRITES)])
        if parameter.name in GOOD and draw.random() < 0.6:
            word = GOOD[parameter.name]
        if parameter.param_type_name == "argument":
            words += [word] * (draw.random() < 0.95)
        elif draw.random() < (0.9 if parameter.required else RARELY):
            name = draw.choice(parameter.opts)
            words += (
                [name] if parameter.is_flag else draw.choice(([name, word], [f"{name}={word}"]))
            )
    if draw.random() < RARELY / 3:
        words.insert(draw.randrange(len(words)), draw.choice(WORDS[:20]))
    return words


def fault(words: list[str]) -> str:
    """What is wrong with the answer to a command line; nothing if it is as it should be."""
    with chdir(_folder()):
        answer = CliRunner().invoke(app, words)
    error = answer.exception
    if error is not None and not isinstance(error, SystemExit):
        return f"{type(error).__name__}: {error}"
    if answer.exit_code not in (0, 1, 2) or "Traceback" in answer.output:
        return f"status {answer.exit_code}: {answer.output}"
    if answer.exit_code and not answer.output.strip():
        return f"status {answer.exit_code} without a sentence"
    told = [c for c in answer.output if not c.isprintable() and c not in "\n\u2028"]
    return f"characters {told} in the answer" if told else ""


def judge(random: Random) -> str | None:
    """What is wrong about the answer to one command line; None: nothing."""
    os.environ["COLUMNS"] = "200"
    words = line(random)
    found = fault(words)
    return f"{found}\n{words!a}" if found else None
