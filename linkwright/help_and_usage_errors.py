"""Pages of help with examples, and errors of a command line in the words of all other errors."""

import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from codegen.errors import InputError
from codegen.plain_values import one_line
from linkwright.command_panels_and_examples import EXAMPLES
from runtime.cli.common import error_head, print_json, write_line

_UsageError: Any = typer.BadParameter.__base__  # which typer does not export
_LONGEST = 2000  # layout: characters of a sentence


class Command(TyperCommand):
    """A command whose page of help ends in examples."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the page, and the examples as lines that can be copied."""
        super().format_help(ctx, formatter)
        show_examples(EXAMPLES.get(self.name or "", ()))


class Commands(TyperGroup):
    """The group of all commands: its errors look like those of the commands."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the page, and the examples as lines that can be copied."""
        super().format_help(ctx, formatter)
        show_examples(EXAMPLES[""])

    def main(
        self, args: Sequence[str] | None = None, prog_name: str | None = None,
        complete_var: str | None = None, standalone_mode: bool = True,
        windows_expand_args: bool = True, **extra: Any,
    ) -> Any:  # fmt: skip
        """Run a command and end the process with its status, unless `standalone_mode` is false."""
        given = list(sys.argv[1:] if args is None else args)
        words = args, prog_name, complete_var, False, windows_expand_args
        if not standalone_mode:
            return super().main(*words, **extra)
        try:
            status = super().main(*words, **extra)
        except _UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
                sys.exit(error.exit_code)
            lines = (_sentence(error, self), *_advice(error.ctx))
            status = _refuse(lines[0], lines[1:], "--json" in given)
        except InputError as error:  # of a default value
            status = _refuse(str(error), (), "--json" in given)
        except typer.Abort:
            status = _refuse("stopped before the end.", (), "--json" in given, 1)
        sys.exit(status if isinstance(status, int) else 0)


def show_examples(lines: Sequence[str]) -> None:
    """Print command lines under a heading, unbroken."""
    if lines:
        typer.echo(f" {typer.style('Examples', bold=True)}")
        for line in lines:
            typer.echo(f"   {line}")
        typer.echo()


def _refuse(problem: str, advice: Sequence[str], as_json: bool, status: int = 2) -> int:
    """Print a problem and what to do; answers the exit status."""
    problem = one_line(problem, _LONGEST)
    write_line(f"{error_head()} {problem}")
    for line in advice:
        write_line(f"  {line}")
    if as_json:
        print_json({"ok": False, "status": status, "problems": [problem]})
    return status


def _sentence(error: Any, group: Commands) -> str:
    """The sentence of a usage error, with the nearest name that there is."""
    text = str(error.format_message())
    option = getattr(error, "option_name", None)
    if option and type(error).__name__ == "NoSuchOption":
        params = error.ctx.command.get_params(error.ctx) if error.ctx else ()
        known = [name for p in params for name in (*p.opts, *p.secondary_opts) if name[:1] == "-"]
        near = get_close_matches(option, known, n=2, cutoff=0.5)
        hint = f"did you mean {' or '.join(near)}?" if near else "--help lists those that there are"
        return f"no option {option}; {hint}"
    if text.startswith("No such command") and error.ctx and error.ctx.command is group:
        head, _, _ = text.partition(" Did you mean")
        name = head.removeprefix("No such command ").rstrip(".")
        near = get_close_matches(name.strip("'\""), list(group.commands), n=2, cutoff=0.6)
        hint = f"did you mean {' or '.join(near)}?" if near else "--help lists those that there are"
        return f"no command {name}; {hint}"
    return text[:1].lower() + text[1:]


def _advice(ctx: Any) -> tuple[str, ...]:
    """Where to look further: the help of the command, and its first example."""
    if ctx is None:
        return ()
    if not ctx.parent:
        return (f"All commands: {ctx.command_path} --help",)
    examples = EXAMPLES.get(ctx.command.name or "", ())
    more = (f"Example: {examples[0]}",) if examples else ()
    return (*more, f"All options: {ctx.command_path} --help")
