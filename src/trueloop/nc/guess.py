"""Which dialect a program is written in, where its text leaves no doubt."""

from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.dialect import DIALECTS
from trueloop.nc.program import read_program


def guess_dialect(source: bytes, file: str | None = None) -> str:
    """The only dialect in which every word of the program makes sense. Raises NC-DIALECT for none or several."""
    strange = {name: len(read_program(source, name).findings) for name in DIALECTS}
    fitting = [name for name, count in strange.items() if count == 0]
    if len(fitting) == 1:
        return fitting[0]
    counts = ", ".join(f"{name} {count}" for name, count in strange.items())
    raise TrueloopError(
        Code.NC_DIALECT,
        f"the program does not tell its dialect: strange words when read as {counts}",
        hint=f"say which: --dialect {' or --dialect '.join(DIALECTS)}",
        place=Place(file),
    )

