"""How commands talk: results on stdout, progress on stderr while a person watches.

What the command line says when something goes wrong, and its exit status.

Messages go to stderr; stdout holds results alone. With `--json` a message is one JSON object:
`{"error": {"code", "message", "hint", "place": {"file", "line", "column"}, "override", "values"}}`,
the values by the names that docs/errors.md has for the code.
"""

import codecs
import functools
import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand
from typer.models import ParameterInfo

from trueloop.cli.options import with_groups
from trueloop.cli.shared_options import option
from trueloop.errors import TrueloopError

if TYPE_CHECKING:
    from rich.console import Console

    from trueloop.report.series.values import FindingShape

AsJson = Annotated[bool, option("Print one JSON object instead, for machines.", "--json")]


@contextmanager
def busy(doing: str) -> Iterator[Callable[[str], None]]:
    """Shows a spinner on stderr, where that is a terminal, while the block runs; yields what sets its text."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status(doing) as status:
        yield status.update


def wide_console() -> "Console":
    """Stdout for people: as wide as the terminal; where there is none, wide enough for every table."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else 160
    return Console(highlight=False, soft_wrap=True, width=width)


def put(text: str, output: Path | None, inputs: Iterable[Path]) -> None:
    """A text on stdout, or in a file, whose name is then printed on stderr. Raises OUT errors."""
    if output is None:
        typer.echo(text, nl=False)
        return
    from trueloop.formats.outputs import write_all

    (written,) = write_all(output.parent, [(output.name, text.encode())], inputs)
    typer.echo(f"written: {written}", err=True)


def print_lines(lines: Iterable[object]) -> None:
    """Prints lines for people on stdout, unchanged."""
    for line in lines:
        typer.echo(str(line))


def print_files(files: Iterable[object]) -> None:
    """Names written files on stderr."""
    for file in files:
        typer.echo(f"written: {file}", err=True)


def finding_lines(findings: "Iterable[FindingShape]") -> list[str]:
    """Findings with their hints."""
    return [f"{finding.severity} {finding.code}: {finding.message}\n  hint: {finding.hint}" for finding in findings]


def print_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """A table for people on stdout: the first column set left, all others right."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for k, name in enumerate(head):
        table.add_column(name, justify="right" if k else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    wide_console().print(table)


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout, escaped where that is not UTF-8. What JSON has no word for must be null already."""
    lossless = codecs.lookup(sys.stdout.encoding or "utf-8").name == "utf-8"
    typer.echo(json.dumps(value, indent=2, ensure_ascii=not lossless, allow_nan=False))


TRACEBACK_VARIABLE = "TRUELOOP_TRACEBACK"


class ExitStatus(IntEnum):
    """The exit status. docs/cli.md carries this table."""

    DONE = 0
    FINDINGS = 1  # a check found an error, a comparison more than its limit, or something could not be determined
    USAGE = 2  # the command line itself was wrong
    REFUSED = 3  # the input was refused: nothing was written
    OUTPUT = 4  # the results could not be written: nothing was written
    INTERNAL = 70  # a fault of trueloop
    INTERRUPTED = 130  # Ctrl-C: nothing was written
    PIPE = 141  # the reader of stdout went away


def guarded(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command for typer, its groups of options as single ones (`with_groups`), with every exception turned into a
    message and an exit status: no traceback reaches a user.

    A file that may not be read is refused by what reads it, with a code: typer would do it first, without.
    """
    single = with_groups(command)
    for annotation in single.__annotations__.values():
        for given in getattr(annotation, "__metadata__", ()):
            if isinstance(given, ParameterInfo):
                given.readable = False

    @functools.wraps(single)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            return single(*args, **kwargs)
        except (typer.Exit, typer.Abort, typer.BadParameter):
            raise
        except TrueloopError as error:
            say(error, as_json=bool(kwargs.get("as_json")))
            raise typer.Exit(status_of(error)) from None
        except KeyboardInterrupt:
            raise typer.Exit(ExitStatus.INTERRUPTED) from None
        except (BrokenPipeError, SystemExit) as end:
            if not reader_gone(end):
                raise
            silence_stdout()
            raise typer.Exit(ExitStatus.PIPE) from None
        except Exception as error:
            _say_internal(error, as_json=bool(kwargs.get("as_json")))
            raise typer.Exit(ExitStatus.INTERNAL) from None

    return run


class Command(TyperCommand):
    """A command whose numbers are refused in words where they have a decimal comma."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Returns what the options leave of the words, as typer does."""
        words = [part for word in args for part in word.split("=", 1)]
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            names = {*error.param.opts, *error.param.secondary_opts} if error.param else set()
            values = [
                value for name, value in pairwise(words) if name in names and re.fullmatch(r"[-+]?\d*,\d+", value)
            ]
            if not values or not re.search("number|float", error.message):
                raise
            message = f"{values[0]} has a decimal comma: write {values[0].replace(',', '.')}"
            raise typer.BadParameter(message, ctx=error.ctx, param=error.param) from None


class Group(typer.Typer):
    """A group of commands, each of them `guarded`; called without a command it prints its help."""

    def __init__(self, words: str) -> None:
        super().__init__(help=words, no_args_is_help=True, rich_markup_mode=None)

    def command(self, name: str | None = None, **settings: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:  # type: ignore[override]
        """Adds the function below as a command: by this name, else by its own."""
        return lambda function: self.add(function, name, **settings)

    def add(self, function: Callable[..., Any], name: str | None = None, **settings: Any) -> Callable[..., Any]:
        """Adds a function as a command: by this name, else by its own without a last underscore."""
        called = name or function.__name__.rstrip("_").replace("_", "-")
        super().command(called, cls=Command, **settings)(guarded(function))
        return function

    def add_all(self, *functions: Callable[..., Any]) -> None:
        """Adds commands by the names of their functions, in the order of the help."""
        for function in functions:
            self.add(function)

    def removed(self, name: str, instead: str) -> None:
        """Refuses a command of an earlier version, with what takes its place."""

        def refuse() -> None:
            raise typer.BadParameter(f"the command {name!r} was removed: {instead}")

        self.add(refuse, name, hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})


def reader_gone(end: BaseException) -> bool:
    """Returns whether stdout is closed: rich and click make a SystemExit of the broken pipe."""
    return isinstance(end, BrokenPipeError) or isinstance(end.__context__, BrokenPipeError)


def silence_stdout() -> None:
    """Python flushes stdout once more when it ends: gives it a place to flush to."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def status_of(error: TrueloopError) -> ExitStatus:
    """OUT codes have a status of their own: the input was good, a second try elsewhere may do."""
    return ExitStatus.OUTPUT if error.code.startswith("OUT-") else ExitStatus.REFUSED


def say(error: TrueloopError, *, as_json: bool) -> None:
    """Prints a refusal on stderr: `file:line:column: CODE: message`, then the hint."""
    if as_json:
        typer.echo(json.dumps({"error": as_dict(error)}, ensure_ascii=False), err=True)
        return
    from rich.console import Console
    from rich.text import Text

    text = Text(str(error))
    text.highlight_words([error.code], "bold red")
    text.highlight_words(["hint:", "override:"], "bold cyan")
    Console(stderr=True, highlight=False, soft_wrap=True).print(text)


def as_dict(error: TrueloopError) -> dict[str, object]:
    """A refusal as `--json` prints it."""
    return {
        "code": error.code,
        "message": error.message,
        "hint": error.hint,
        "place": asdict(error.place),
        "override": error.override,
        "values": error.json_values,
    }


def _say_internal(error: Exception, *, as_json: bool) -> None:
    if os.environ.get(TRACEBACK_VARIABLE):
        import traceback

        traceback.print_exception(error)
    message = f"{type(error).__name__}: {error}"
    hint = f"this is a fault of trueloop, not of your files; with {TRACEBACK_VARIABLE}=1 it prints what to report"
    if as_json:
        typer.echo(json.dumps({"error": {"code": "INTERNAL", "message": message, "hint": hint}}), err=True)
    else:
        typer.echo(f"INTERNAL: {message}\n  hint: {hint}", err=True)
