"""Write docs/reference/command-line.md, every command with its options, from the parser.

Usage: ``python docs/make_command_line.py [--check]``. With ``--check`` nothing is written; the exit
status is 1 where the page is stale.
"""

import sys
from pathlib import Path
from typing import Any

import typer
from typer.main import get_command

from linkwright.cli.application import app

PAGE = Path(__file__).resolve().parent / "reference" / "command-line.md"

HEAD = """# The command line

`linkwright` is the one command of the project. `docs/make_command_line.py` makes this page from the
command's parser, and `make check` compares the page with the parser. `linkwright COMMAND --help`
shows the same in a terminal.

Results go to stdout, messages and progress to stderr. With `--json`, stdout holds one object.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | the run or a comparison failed; the message says at which t, and what was saved |
| 2 | the input is wrong; every problem is on a line of stderr that begins with `error:` |
| 128 + n | stopped by signal n: 129 SIGHUP, 130 SIGINT, 143 SIGTERM |

MODEL is the path of a model file, or the name of a file in the folder `models` of the working
folder or of the library. Without MODEL, the only model file of the working folder is taken.

`linkwright --install-completion` installs the completion of words for the shell at hand, bash, zsh,
fish or PowerShell: commands, options, models, scenes, parameters, coordinates, methods and kinds of
elements. The names of a model are read from the text of its file; the file is not executed.

The examples run in a folder with the file that `linkwright new four_bar` writes.
"""


def section(command: Any) -> str:
    """The section of a command: its parameters as its help has them, and its examples."""
    context = typer.Context(command, info_name=command.name)
    records = [p.get_help_record(context) for p in command.params]
    rows = ""
    for names, text in filter(None, records):
        cell = " ".join(text.split()).replace(r"\[", "[").replace("|", r"\|")
        rows += f"| `{names}` | {cell} |\n"
    about = " ".join((command.help or "").split())
    _, *examples = command.epilog.split("\n\n")
    lines = "\n".join(examples)
    return (
        f"\n### `linkwright {command.name}`\n\n{about}\n\n"
        f"| argument or option | meaning |\n|---|---|\n{rows}\n```\n{lines}\n```\n"
    )


def page() -> str:
    """The text of docs/reference/command-line.md."""
    parts, panel = [HEAD], ""
    for command in get_command(app).commands.values():
        if command.rich_help_panel != panel:
            panel = command.rich_help_panel
            parts.append(f"\n## {panel}\n")
        parts.append(section(command))
    return "".join(parts)


def main() -> int:
    """Write the page, or compare it."""
    made = page()
    if "--check" in sys.argv[1:]:
        stale = not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != made
        if stale:
            print(f"{PAGE} is stale; run: python docs/make_command_line.py", file=sys.stderr)
        return int(stale)
    PAGE.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
