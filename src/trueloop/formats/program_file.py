"""Files of NC programs."""

from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.input_file import FilePath, read_input
from trueloop.nc.program import program as programs
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, Unit


def read_program(path: FilePath, dialect: str | None = None, unit: Unit | None = None, decimals: int = 0) -> Program:
    """The program of a file; its dialect is guessed where none is named, `unit` and `decimals` as for its bytes.

    Raises NC-FILE, NC-DIALECT and NC-LIMIT.

    >>> program = trueloop.read_program(trueloop.example("modbas2/finish.nc"), dialect="ge2000t")
    >>> program.block_count, program.parameters_used()
    (39, ('P42', 'P46', 'P47'))
    >>> path = program.run({"P42": 8.0, "P46": 3.52, "P47": 0.0})
    >>> len(path), path.end_mm[10].round(3).tolist()  # moves; X as a radius, Y, Z
    (16, [0.0, 0.0, 0.794])
    """
    file = Path(path)
    source, known = read_source(file, dialect)
    return programs.read_program(source, known, str(file), unit, decimals)


def read_source(path: Path, dialect: str | None) -> tuple[bytes, str]:
    """The bytes of a program and its dialect, guessed where none is named. Raises NC-FILE and NC-DIALECT."""
    source = read_input(path, Code.NC_FILE, hint="name an NC program")
    return source, dialect_named(guess_dialect(source, str(path)) if dialect is None else dialect).name
