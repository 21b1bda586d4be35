"""The words of controls that add to a tool's offset: in a program of its own, or by hand at the control.

All of them add, so that nothing else of the offset is lost, but those of the GE 2000T, which set it.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Final, Literal, TypeAlias, get_args

from trueloop.errors import Code
from trueloop.turned.program.wear_numbers import WearOffset

Control: TypeAlias = Literal["fanuc", "haas", "siemens", "heidenhain", "linuxcnc", "ge2000t", "okuma"]
CONTROLS: Final[tuple[Control, ...]] = get_args(Control)


def blocks_of(control: Control | Literal[""], wear: WearOffset) -> tuple[str, ...]:
    """Returns the blocks of a control; () where it has no words for these numbers, or they are not known."""
    return BLOCKS[control](wear) if control in BLOCKS else ()


def updates(wear: WearOffset, own: Mapping[str, float]) -> tuple[str, ...]:
    """GE 2000T: an update sets the offset, to what the program itself sets, in its unit, and the wear."""
    values = {"X": own["X"] + wear.x, "Z": own["Z"] + wear.z}
    return tuple(f"(UPD, {wear.tool}, TOV({axis}), {value:.{wear.decimals}f})" for axis, value in values.items())


def counted(control: Control, stated: Literal["radius", "diameter"] | None) -> Literal["radius", "diameter"]:
    """Returns how a control counts offsets on X that another control's program was corrected for.

    LinuxCNC's words say it themselves, a Sinumerik counts radii as delivered. Raises OFS-WORDS for the others, which
    are set up in either way, where it is not stated.
    """
    if stated is not None or control in ("siemens", "linuxcnc", "heidenhain", "ge2000t"):
        return stated or "radius"
    raise Code.OFS_WORDS.refusal(
        f"{control!r}: whether offsets on X are radii or diameters is not stated; twice the offset would be wrong",
        hint="state it: `--x-is radius` or `--x-is diameter`",
        values={"control": control},
    )


def offset_program(control: Control, wear: WearOffset, record_id: str) -> str:
    """Returns a small program that adds the offset, to be run once; `wear.blocks` are taken for a GE 2000T.

    Raises OFS-WORDS for a control without words for it.
    """
    blocks = wear.blocks if control == "ge2000t" else blocks_of(control, wear)
    if not blocks:
        raise Code.OFS_WORDS.refusal(
            f"{control!r}: {WHY[control]} ({wear.words})",
            hint="enter the numbers at the control, or write its tool table: `trueloop offsets apply`",
            values={"control": control},
        )
    return "\n".join([*_framed(control, blocks, f"trueloop offset {record_id}, run once"), ""])


def _framed(control: Control, blocks: tuple[str, ...], comment: str) -> Iterator[str]:
    """Yields the blocks with a comment and an end, as the control loads programs."""
    if control == "siemens":
        yield from (f"; {comment}", *blocks, "M30")
    elif control == "ge2000t":
        yield from (f"! {comment}", *blocks, "M30")
    elif control == "linuxcnc":
        yield from (f"({comment})", *blocks, "M2")
    elif control == "okuma":
        yield from (f"({comment.upper()})", *blocks, "M02")
    else:
        yield from ("%", f"({comment.upper()})", *blocks, "M30", "%")


def _unit(wear: WearOffset) -> str:
    return "G20" if wear.unit == "inch" else "G21"


def _fanuc(wear: WearOffset, code: str = "G10") -> tuple[str, ...]:
    """U and W are increments; P from 1 on are wear offsets."""
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    return (f"{_unit(wear)} {code} P{wear.tool} U{x} W{z}",)


def _haas(wear: WearOffset) -> tuple[str, ...]:
    return _fanuc(wear, "G10 L11")


def _siemens(wear: WearOffset) -> tuple[str, ...]:
    """Of a turning tool length 1 lies along X, length 2 along Z."""
    if wear.unit == "inch":  # whether the control keeps its tools in inches is not in the program
        return ()
    return _added((f"$TC_DP{number}[{wear.tool},{wear.edge}]" for number in (12, 13)), wear)


def _okuma(wear: WearOffset) -> tuple[str, ...]:
    """The unit is the control's: G20 and G21 are other codes there."""
    return _added((f"{name}[{wear.tool}]" for name in ("VTOFX", "VTOFZ")), wear)


def _added(keys: Iterator[str], wear: WearOffset) -> tuple[str, ...]:
    return tuple(f"{key}={key}{wear.number(value)}" for key, value in zip(keys, (wear.x, wear.z), strict=True))


def _linuxcnc(wear: WearOffset) -> tuple[str, ...]:
    """Under the offset in force, the place where the tool stands is called by that much less: the table follows.

    Unlike G10 L1 with what #5401 holds, this does not depend on the unit of the table. #<_x> is a radius always, the
    X of G10 a diameter under G7.
    """
    mode, here = ("G7", "2*#<_x>") if wear.x_is_diameter else ("G8", "#<_x>")
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    change = f"G10 L10 P{wear.tool} X[{here}-[{x}]] Z[#<_z>-[{z}]]"
    return f"{_unit(wear)} {mode} G40 T{wear.tool} M6", "G43", change, "G43"


BLOCKS: Final[Mapping[str, Callable[[WearOffset], tuple[str, ...]]]] = {
    "fanuc": _fanuc,
    "haas": _haas,
    "linuxcnc": _linuxcnc,
    "siemens": _siemens,
    "okuma": _okuma,
}
WHY: Final[Mapping[Control, str]] = {
    "heidenhain": "no words of a program are known that change the tool table",
    "siemens": "whether the control keeps its tools in inch is not in the program",
    "ge2000t": "an update sets the whole offset, which a program for another control does not say",
}
"""The reasons why a control has no words for an offset."""
