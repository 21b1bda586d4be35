"""Whether residuals can tell what is wrong, and what they cannot."""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.terms.suspects import Residuals
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.machine.model.chain import Chain

PARTS: Final = 2
UNKNOWNS: Final = 2
"""Of an error that follows a temperature, beside where each part is set up."""
ALIKE_MM: Final = 1.0
ALIKE_K: Final = 0.5
"""Ranges below which tools, positions and temperatures count as alike."""


def check(chain: Chain, seen: Residuals) -> tuple[Finding, ...]:
    """What the data lack, as notes with DIA-ALIKE.

    Raises MCH-SHAPE for arrays that do not fit, MCH-AXIS for an element of no axis, DIA-SIGNAL for a temperature that
    is missing or not finite, DIA-POINTS for other values that are not finite, DIA-FEW for one part or few points.
    """
    _check_shapes(chain, seen)
    for axis in seen.element:
        chain.axis(axis)
    _check_signals(seen)
    _check_finite(seen)
    _check_number(seen)
    return (*_equal_temperatures(seen), *_one_tool(seen), *_one_place(chain, seen))


def _check_shapes(chain: Chain, seen: Residuals) -> None:
    count, state = len(seen.residual_mm), seen.state
    shapes = (seen.part.shape, seen.normal.shape, state.positions.shape, np.shape(state.tool_mm))
    wanted = ((count,), (count, 3), (count, len(chain.order)))
    signals = [np.shape(values) for values in state.signals.values()]
    if shapes[:3] != wanted or shapes[3] not in ((3,), (count, 3)) or any(s not in ((), (count,)) for s in signals):
        raise TrueloopError(
            Code.MCH_SHAPE,
            f"{count} residuals with parts, normals, positions and tools of the shapes {shapes} do not fit",
            hint=f"give parts (n,), normals (n, 3), positions (n, {len(chain.order)}), tools (3,) or (n, 3)",
            values={"counts": [int(shape[0]) for shape in shapes]},
        )


def _check_signals(seen: Residuals) -> None:
    for signal in sorted({*seen.element.values(), *seen.state.signals}):
        given = seen.state.signals.get(signal)
        known = np.isfinite(np.broadcast_to(np.nan if given is None else np.asarray(given), seen.part.shape))
        if not known.all():
            parts = [int(part) for part in np.unique(seen.part[~known])]
            raise TrueloopError(
                Code.DIA_SIGNAL,
                f"the signal {signal!r} is not known of {len(parts)} of {len(np.unique(seen.part))} parts",
                hint="leave those parts out, or name another signal as the temperature of that element",
                values={"signal": signal, "parts": parts},
            )


def _check_finite(seen: Residuals) -> None:
    arrays = (seen.residual_mm[:, None], seen.normal, seen.state.positions, np.atleast_2d(seen.state.tool_mm))
    finite = np.ones(len(seen.part), bool)
    for values in arrays:
        finite &= np.isfinite(values).all(axis=1)
    if not finite.all():
        raise TrueloopError(
            Code.DIA_POINTS,
            f"{int((~finite).sum())} of {len(finite)} points have a residual, normal, position or tool that is no "
            f"finite number, the first in row {int(np.argmin(finite)) + 1}",
            hint="leave out points that were not measured",
            values={"feature": ""},
        )


def _check_number(seen: Residuals) -> None:
    parts, points = len(np.unique(seen.part)), len(seen.part)
    directions = int(np.any(np.abs(seen.normal) > 1e-9, axis=0).sum()) if points else 0
    if parts < PARTS:
        raise _few(parts, PARTS, f"{parts} part of {points} points does not tell an axis error from its set-up")
    needed = parts * directions + UNKNOWNS
    if points < needed:
        raise _few(points, needed, f"{points} points on {parts} parts do not determine set-ups and an error")


def _few(count: int, needed: int, message: str) -> TrueloopError:
    return TrueloopError(
        Code.DIA_FEW,
        f"{message}; needed are {needed}",
        hint="measure more parts, at other temperatures, with tools of other lengths, at more points",
        values={"count": count, "needed": needed},
    )


def _equal_temperatures(seen: Residuals) -> list[Finding]:
    spans = {signal: _range(seen.state.signals[signal]) for signal in sorted(set(seen.element.values()))}
    equal = [signal for signal, span in spans.items() if span < ALIKE_K]
    if not equal:
        return []
    return [
        _alike(
            f"{', '.join(equal)} changed by less than {ALIKE_K:g} K over the parts: what follows it does not show",
            "measure parts cut when the machine was cold and when it was warm",
        )
    ]


def _one_tool(seen: Residuals) -> list[Finding]:
    tools = np.atleast_2d(seen.state.tool_mm)
    if float(np.ptp(tools, axis=0).max()) >= ALIKE_MM:
        return []
    return [
        _alike(
            f"one length of tool and stylus (to {ALIKE_MM:g} mm) at all points: angles and displacements look alike",
            "probe with longer and shorter styli too",
        )
    ]


def _one_place(chain: Chain, seen: Residuals) -> list[Finding]:
    spans = np.ptp(seen.state.positions, axis=0)
    fixed = [name for name, span in zip(chain.order, spans, strict=True) if span < ALIKE_MM and name in "XYZ"]
    if not fixed:
        return []
    return [
        _alike(
            f"{', '.join(fixed)} stood within {ALIKE_MM:g} mm at all points: what depends on it does not show",
            "measure parts of other diameters and lengths too",
        )
    ]


def _alike(message: str, hint: str) -> Finding:
    return Finding(Severity.NOTE, Code.DIA_ALIKE, message, hint)


def _range(values: Array | float) -> float:
    return float(np.ptp(np.atleast_1d(values)))
