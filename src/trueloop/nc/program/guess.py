"""Which dialect a program is written in, where its text and its file's name leave no doubt."""

from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import NOT_UNDERSTOOD


def guess_dialect(source: bytes, file: str | None = None, option: str = "--dialect {}") -> str:
    """The only dialect in which every word of the program makes sense. Raises NC-DIALECT for none or several.

    `option` is how a user says which. Of several, LinuxCNC's is taken where the file's name ends in .ngc, which no
    other control uses.
    """
    strange = {name: _strange_words(source, name) for name in DIALECTS}
    fitting = [name for name, count in strange.items() if count == 0]
    if "linuxcnc" in fitting and (file or "").lower().endswith(".ngc"):
        return "linuxcnc"
    if len(fitting) == 1:
        return fitting[0]
    counts = ", ".join(f"{name} {count}" for name, count in strange.items())
    raise TrueloopError(
        Code.NC_DIALECT,
        f"the program does not tell its dialect: strange words when read as {counts}",
        hint=f"say which: {' or '.join(map(option.format, fitting or DIALECTS))}",
        place=Place(file),
    )


def _strange_words(source: bytes, dialect: str) -> int:
    return sum(finding.code in NOT_UNDERSTOOD for finding in read_program(source, dialect).findings)
