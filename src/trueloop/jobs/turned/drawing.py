"""A part's profile from whatever drawing there is of it: DXF, STEP or IGES, by the name's ending."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.domain.characteristic import Characteristic
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.geometry.profile import Profile, Side
from trueloop.geometry.validate import checked_profile
from trueloop.nc.program.program import Unit

CAD: Final = {".dxf": "dxf", ".step": "step", ".stp": "step", ".igs": "step", ".iges": "step"}
"""The key of the job by the drawing's ending."""

Zero: TypeAlias = Literal["drawing", "free-end", "chuck-end"]


@dataclass(frozen=True)
class Chosen:
    """What of a drawing is meant: a contour by its number (None: there is one), and from where z of a DXF counts."""

    outline: int | None = None
    zero: Zero = "drawing"

    def keys(self, of: str) -> dict[str, int | str]:
        """Returns the choice as keys of a job's table [part]; `of`: `dxf` or `step`."""
        outline = {} if self.outline is None else {f"{of}_outline": self.outline}
        return outline | ({} if self.zero == "drawing" else {f"{of}_zero": self.zero})


AS_DRAWN: Final = Chosen()


@dataclass(frozen=True)
class Drawn:
    """The profile, what the drawing asks for, and in words how it was read."""

    profile: Profile
    notes: tuple[str, ...]
    asked: tuple[Characteristic, ...] = ()


def read_drawing(path: Path, side: Side = Side.OUTSIDE, unit: Unit | None = None, chosen: Chosen = AS_DRAWN) -> Drawn:
    """Reads the outside or the bore; `unit` is that of a DXF drawing that states none. Raises GEO and SRF errors."""
    if drawing_key(path) == "dxf":
        from trueloop.formats.cad.dxf import read_dxf  # ezdxf takes long to import

        drawn = read_dxf(path, unit=unit, side=side, outline=chosen.outline, zero=chosen.zero)
        with in_file(path):
            return Drawn(checked_profile(drawn.features, side=side), drawn.notes)
    from trueloop.formats.cad.step_profile import read_step_profile  # so does the kernel
    from trueloop.formats.cad.step_tolerances import fitting

    solid = read_step_profile(path, side=side, outline=chosen.outline)
    with in_file(path):
        profile = checked_profile(solid.features, side=side)
    asked = fitting(solid.characteristics, profile)
    return Drawn(profile, (*solid.notes, *asked.notes), asked.characteristics)


def drawing_key(drawing: Path) -> str:
    """Returns the job's key for a drawing. Raises GEO-DXF for an ending that is not a drawing's."""
    key = CAD.get(drawing.suffix.lower())
    if key is None:
        raise TrueloopError(
            Code.GEO_DXF,
            f"{drawing.name!r} ends neither in {', '.join(CAD)}",
            hint="give a DXF drawing, or a STEP or IGES file of the solid",
            place=Place(str(drawing)),
        )
    return key
