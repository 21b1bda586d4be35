"""A program that is not there."""

from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.input_file import read_input

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.NC_FILE: lambda: read_input(Path("/nowhere/finish.nc"), Code.NC_FILE, hint="name a program")
}
