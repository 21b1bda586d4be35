"""Turning or milling: a program for one is no program for the other."""

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.program.tool_path import ToolPath
from trueloop.nc.translate.executed import Source


def require_same_kind(source: Source, to: str) -> None:
    """Raises NC-LOST for a turning program that shall become one for a mill, or the other way round.

    A program of a control that does both is for turning where X is a diameter or the surface speed constant, for
    milling where Y moves; otherwise it may be for either.
    """
    kind, why, line = _kind(source)
    wanted = source.target.kind
    if "either" in (kind, wanted) or kind == wanted:
        return
    raise TrueloopError(
        Code.NC_LOST,
        f"the program is for {kind} ({why}), {to} for {wanted}",
        hint=f"translate it to a control for {kind}",
        place=Place(source.program.file, line),
    )


def _kind(source: Source) -> tuple[str, str, int | None]:
    path, name = source.path, source.program.dialect.name
    if source.control.kind != "either":
        return source.control.kind, f"its dialect is {name}", None
    reasons = (
        ("turning", "X is a diameter", path.diameter),
        ("turning", "the surface speed is constant", path.spindle_mode == 96),
        ("milling", "Y moves", _y_moves(path)),
    )
    for kind, why, here in reasons:
        if here.any():
            return kind, why, int(path.line[np.flatnonzero(here)[0]])
    return "either", "", None


def _y_moves(path: ToolPath) -> np.ndarray:
    moves: np.ndarray = np.abs(path.end_mm[:, 1] - path.start_mm[:, 1]) > 1e-9
    return moves
