"""The content of an image, as text and as JSON."""

from collections.abc import Iterator

from trueloop.machine.model.chain import Vector, in_words
from trueloop.realtime.image import Image, Signal
from trueloop.realtime.largest import Extent, Largest
from trueloop.units import UM_PER_MM

SLEW_MM_PER_S = 5.0
"""Of the component, where nothing else is set."""


def image_lines(image: Image, extent: Extent) -> Iterator[str]:
    """Yields lines of text on an image."""
    identity, limits = image.identity, image.limits
    yield f"image for the machine {identity.machine!r}, serial number {identity.serial!r}"
    yield from _model_lines(image, extent)
    travel = ", ".join(f"{axis} {low:g} to {high:g}" for axis, (low, high) in zip("XYZ", limits.travel_mm, strict=True))
    yield f"travel of the drives: {travel} mm"
    yield from _table_lines(image, extent)
    whole = where_in_words(extent.whole, image)
    yield f"largest correction {_um(extent.whole.correction_mm)} along {whole}; limit {_um(limits.limit_mm)}"


def _model_lines(image: Image, extent: Extent) -> Iterator[str]:
    bank = image.bank
    if bank is None:
        yield "no model: it corrects by its table alone"
        return
    yield f"model: {len(bank.bodies)} carriers of errors, sha256 {image.identity.model_sha256[:16]}…"
    for place, signal in enumerate(bank.signals):
        yield f"  rtec.signal-{place}: {_signal(signal)}"
    yield f"  tool point {_vector(bank.tool_mm)} from the frame of the last axis; a tool offset in force is subtracted"
    if extent.model is not None:
        yield (
            f"  up to {_um(extent.model.correction_mm)} along {where_in_words(extent.model, image)}, "
            f"of {extent.places} places in the travel"
        )
    if extent.jump_mm:
        slew = extent.jump_mm / SLEW_MM_PER_S * 1e3
        yield (
            f"  it jumps by up to {_um(extent.jump_mm)} where an axis turns round, "
            f"which takes {slew:.1f} ms at {SLEW_MM_PER_S:g} mm/s"
        )


def _signal(signal: Signal) -> str:
    low, high, step = (in_words(value, signal.unit) for value in (signal.low, signal.high, signal.most_step))
    return f"{signal.name}, {low} to {high}, at most {step} between two readings"


def _table_lines(image: Image, extent: Extent) -> Iterator[str]:
    if extent.table is None:
        yield "no table: it corrects the machine alone"
        return
    identity, rows = image.identity, sum(len(block.rows) for block in image.blocks)
    yield (
        f"table: {len(image.blocks)} blocks of {identity.program}, lines {image.blocks[0].line} to "
        f"{image.blocks[-1].line}, {rows} rows, up to {_um(extent.table.correction_mm)} along "
        f"{where_in_words(extent.table, image)}; within {_um(image.limits.gate_mm)} of its path"
    )
    yield (
        f"  run {identity.program} as it is (sha256 {identity.program_sha256[:16]}…): "
        f"the program corrected by record {identity.record} must not be run with this image"
    )


def where_in_words(largest: Largest, image: Image) -> str:
    """Axis, place and signals of a correction."""
    signals = image.bank.signals if image.bank and largest.signals else ()
    at = [f"{s.name} {in_words(value, s.unit)}" for s, value in zip(signals, largest.signals, strict=True)]
    return ", ".join([f"{largest.axis} at {_vector(largest.position_mm)}", *at])


def _vector(vector: Vector) -> str:
    return "({:g}, {:g}, {:g}) mm".format(*vector)


def _um(length_mm: float) -> str:
    return f"{length_mm * UM_PER_MM:.1f} µm"


def image_summary(image: Image, extent: Extent) -> dict[str, object]:
    """Converts an image to a dict; lengths in mm where no unit is given, None for what the image does not hold."""
    bank, identity = image.bank, image.identity
    return {
        **identity.__dict__,
        "signals": [signal.__dict__ for signal in bank.signals] if bank else [],
        "carriers": len(bank.bodies) if bank else 0,
        "tool_mm": list(bank.tool_mm) if bank else None,
        "travel_mm": dict(zip("XYZ", map(list, image.limits.travel_mm), strict=True)),
        "limit_um": image.limits.limit_mm * UM_PER_MM,
        "gate_um": image.limits.gate_mm * UM_PER_MM,
        "blocks": len(image.blocks),
        "rows": sum(len(block.rows) for block in image.blocks),
        "largest": _plain(extent.whole),
        "largest_of_model": _plain(extent.model),
        "largest_of_table": _plain(extent.table),
        "jump_um": extent.jump_mm * UM_PER_MM,
    }


def _plain(largest: Largest | None) -> dict[str, object] | None:
    if largest is None:
        return None
    return {
        "axis": largest.axis,
        "correction_um": largest.correction_mm * UM_PER_MM,
        "position_mm": list(largest.position_mm),
        "signals": list(largest.signals),
    }
