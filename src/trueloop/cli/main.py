"""`trueloop`: the commands. The module of each is imported when it is called, and imports the rest when it runs."""

import codecs
import os
import sys
import unicodedata
from importlib import import_module
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup
from typer.main import get_group

HANDLER: Final = "trueloop-ascii"
ASCII: Final = "trueloop_ascii"
"""The codec of streams that are ASCII: click would write UTF-8 to one that is called `ascii`."""
_WRITTEN: Final = {
    **{"±": "+-", "µ": "u", "μ": "u", "°": " deg", "…": "...", "–": "-", "—": "-", "−": "-", "·": "*", "×": "x"},
    **{"’": "'", "‘": "'", "“": '"', "”": '"', "′": "'", "″": '"', "→": "->", "←": "<-", "↑": "^", "↓": "v"},
    **{"≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "Ø": "dia ", "ø": "dia ", "⌀": "dia ", "∅": "dia ", "√": "sqrt"},
    **{"✓": "ok", "✗": "x", "●": "*", "○": "o", "■": "#", "▲": "^", "▼": "v", "÷": "/", "ß": "ss", "§": "section "},
    **{"─": "-", "━": "-", "│": "|", "┃": "|", "\N{ZERO WIDTH NO-BREAK SPACE}": ""},
}

_OF_STDOUT: Final = ("strict", "surrogateescape")
"""How Python itself sets stdout up; the second on Windows, and elsewhere in the locale C."""


def plain(text: str) -> str:
    """Returns the text in ASCII: by the table, else without accents, a Greek letter by its name, else `?`."""
    return "".join(character if character.isascii() else _plain(character) for character in text)


def _plain(character: str) -> str:
    if character in _WRITTEN:
        return _WRITTEN[character]
    without = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    name = unicodedata.name(character, "")
    if name.startswith("GREEK ") and " LETTER " in name:
        letter = name.rpartition(" LETTER ")[2].partition(" ")[0]
        return letter.lower() if "SMALL" in name else letter.capitalize()
    return without or ("" if unicodedata.combining(character) else "?")


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end


def _encoded(text: str, errors: str = "strict") -> tuple[bytes, int]:
    return plain(text).encode("ascii"), len(text)


class _Encoder(codecs.IncrementalEncoder):
    def encode(self, text: str, final: bool = False) -> bytes:
        return _encoded(text)[0]


def _codec(name: str) -> codecs.CodecInfo | None:
    if name != ASCII:
        return None
    return codecs.CodecInfo(_encoded, codecs.ascii_decode, incrementalencoder=_Encoder, name=ASCII)


def write_what_streams_take() -> None:
    """Sets stdout and stderr up so that no text fails on them; what the user set by PYTHONIOENCODING stays."""
    codecs.register_error(HANDLER, _replaced)
    codecs.register(_codec)
    for stream, own in ((sys.stdout, _OF_STDOUT), (sys.stderr, ("backslashreplace",))):
        errors = getattr(stream, "errors", None)
        if errors not in own:
            continue
        encoding = codecs.lookup(stream.encoding).name
        if encoding == "utf-8" and errors == "surrogateescape":
            continue  # writes names of files that are not UTF-8 as they are
        if encoding == "ascii":
            stream.reconfigure(encoding=ASCII)  # type: ignore[union-attr]
        else:
            stream.reconfigure(errors=HANDLER)  # type: ignore[union-attr]


THREADS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Threads of numpy's and scipy's linear algebra: one, unless the user says otherwise before the start. Ours are small
problems, which several threads slow down, and two programs side by side would fight for the cores.
"""

COMMANDS: Final = {
    "new": "trueloop.cli.new:new",
    "compensate": "trueloop.cli.compensate:compensate",
    "demo": "trueloop.cli.compensate:demo",
    "examples": "trueloop.cli.help:examples",
    "simulate": "trueloop.cli.simulated:simulate",
    "serve": "trueloop.cli.serve:serve",
    "explain": "trueloop.cli.help:explain",
    "docs": "trueloop.cli.help:docs",
    "part": "trueloop.cli.part:app",
    "nc": "trueloop.cli.nc:app",
    "probe": "trueloop.cli.probe:app",
    "measure": "trueloop.cli.measure:app",
    "linuxcnc": "trueloop.cli.simulated:app",
    "machine": "trueloop.cli.machine:app",
    "realtime": "trueloop.cli.realtime:app",
    "surface": "trueloop.cli.surface:app",
    "mill": "trueloop.cli.mill:app",
    "series": "trueloop.cli.series:app",
    "monitor": "trueloop.cli.monitor:app",
    "diagnose": "trueloop.cli.diagnose:app",
    "offsets": "trueloop.cli.offsets:app",
    "link": "trueloop.cli.link:app",
    "mtconnect": "trueloop.cli.mtconnect:app",
    "tool": "trueloop.cli.tool:app",
    "record": "trueloop.cli.offsets:records",
    "db": "trueloop.cli.db:app",
    "user": "trueloop.cli.user:app",
    "key": "trueloop.cli.user:keys",
    "cell": "trueloop.cli.cell:app",
}
"""Where each command or group of commands is, in the order of `--help`."""


class _Commands(dict[str, Any]):
    """Commands by name; the value None stands for one whose module is not imported yet."""

    def __getitem__(self, name: str) -> Any:
        if super().__getitem__(name) is None:
            self[name] = _imported(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Returns the command, imported."""
        if name not in self:
            return default
        return self[name]


class _Group(TyperGroup):
    """Imports the module of a command when the command is looked up."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _Commands(dict.fromkeys(COMMANDS))

    def list_commands(self, ctx: Any) -> list[str]:
        """Returns their names; none is imported for it."""
        return list(self.commands)


def _imported(name: str) -> Any:
    """Imports a command, or a group of commands, and makes of it what typer makes within a group."""
    from trueloop.cli.terminal import Command

    module, _, attribute = COMMANDS[name].partition(":")
    value = getattr(import_module(module), attribute)
    holder = typer.Typer(rich_markup_mode=None, add_completion=False)
    if isinstance(value, typer.Typer):
        holder.add_typer(value, name=name)
    else:
        holder.command(name, cls=Command)(value)
    return get_group(holder).commands[name]


app = typer.Typer(
    name="trueloop",
    cls=_Group,
    help="Closed-loop machining: measure the part, model the error, cut the next pass true.",
    epilog="Exit status: 0 done, 1 found what was looked for (a check, a limit), 2 usage, 3 input refused, "
    "4 output not written, 70 internal error, 130 interrupted, 141 stdout closed.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: a third of the time that rich takes
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from trueloop import __version__

        typer.echo(f"trueloop {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """The entry point of the command `trueloop`."""
    for name in THREADS:
        os.environ.setdefault(name, "1")
    write_what_streams_take()
    try:
        app()
    except SystemExit as end:  # help and version are printed outside of any command
        from trueloop.cli.terminal import ExitStatus, reader_gone, silence_stdout

        if not reader_gone(end):
            raise
        silence_stdout()
        sys.exit(ExitStatus.PIPE)
