"""Which dialect a program is written in, where its text and its file's name leave no doubt."""

from pathlib import Path

from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import NOT_UNDERSTOOD


def guess_dialect(source: bytes, file: str | None = None, option: str = "--dialect {}") -> str:
    """The only dialect in which every word of the program makes sense. Raises NC-DIALECT for none or several.

    `option` is how a user says which. Of several, the one is taken whose control alone uses the ending of the file's
    name: .ngc of LinuxCNC.
    """
    strange = _strange(source)
    fitting = [name for name, count in strange.items() if count == 0]
    by_ending = [name for name in fitting if DIALECTS[name].file_ending == Path(file or "").suffix.lower()]
    if len(only := by_ending or fitting) == 1:
        return only[0]
    counts = ", ".join(f"{name} {count}" for name, count in strange.items())
    raise TrueloopError(
        Code.NC_DIALECT,
        f"the program does not tell its dialect: strange words when read as {counts}",
        hint=f"say which: {' or '.join(map(option.format, fitting or DIALECTS))}",
        place=Place(file),
    )


def likeliest_dialect(source: bytes) -> str:
    """The dialect in which the fewest words are strange, the first of several: enough to split a line into words."""
    strange = _strange(source)
    return min(strange, key=lambda name: strange[name])


def _strange(source: bytes) -> dict[str, int]:
    return {name: _strange_words(source, name) for name in DIALECTS}


def _strange_words(source: bytes, dialect: str) -> int:
    return sum(finding.code in NOT_UNDERSTOOD for finding in read_program(source, dialect).findings)
