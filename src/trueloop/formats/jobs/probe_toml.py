"""The probe file (TOML): stylus, approach, how programs are written, and the calibration."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from trueloop.errors import Code
from trueloop.formats.toml_tables import (
    Count,
    Finite,
    NotNegative,
    Positive,
    Table,
    options_from,
    read_tables,
    with_options,
)
from trueloop.probing.calibration import BallCalibration, Stylus
from trueloop.probing.probe_plan import Approach, SecondTouch
from trueloop.units import UM_PER_MM

LEAST_BACK_OFF_MM: Final = 0.1
"""Shorter ways cannot be distinguished from a probe that is still triggered."""

MOST_LOBING_UM: Final = 200.0
"""Larger values of a calibration are in another unit."""


@with_options("stylus", Stylus)
class StylusTable(Table):
    """Ball and stem of the stylus."""


@with_options("approach", Approach)
class ApproachTable(Table):
    """How points are approached, and how thick the bar behind the part is."""

    bar_radius_mm: Positive | None = None
    """Radius of bar or chuck behind the part; left out, that of the profile where it begins."""


class ProgramTable(Table):
    """How probing programs are written; with the `second` keys every point is touched again, slowly."""

    unit: Literal["mm", "inch"] = "mm"
    """How the program writes coordinates, and what the log holds: `"mm"` or `"inch"`."""
    x_is: Literal["radius", "diameter"] = "diameter"
    """How X counts: `"radius"` or `"diameter"`."""
    probe_feed_mm_per_min: Positive = 60.0
    """A control latches once a servo period: at 60 mm/min that is a micrometre."""
    position_feed_mm_per_min: Positive = 2000.0
    """Between touches, in straight lines."""
    second_feed_mm_per_min: Positive | None = None
    """Touch every point again at this feed: LinuxCNC, Fanuc, Haas and Siemens. Left out, points are touched once."""
    second_back_off_mm: Annotated[Positive, Field(ge=LEAST_BACK_OFF_MM)] | None = None
    """From how far back the second touch begins, 0.1 at least; required with `second_feed_mm_per_min`."""
    tool: Count = 9
    """The probe's tool number."""
    work_offset: Annotated[int, Field(ge=54, le=59, strict=True)] = 54
    """54 to 59: G54 to G59."""
    log: Annotated[str, Field(pattern=r"^[\w.-]+$")] = "touches.txt"
    """The log's name."""
    program_number: Annotated[int, Field(ge=1, le=8999, strict=True)] = 8100
    """O number of the program, 1 to 8999: above, controls protect programs."""

    @model_validator(mode="after")
    def _slow_second(self) -> "ProgramTable":
        if (self.second_feed_mm_per_min is None) != (self.second_back_off_mm is None):
            raise ValueError("`second_feed_mm_per_min` and `second_back_off_mm` go together")
        if (self.second_feed_mm_per_min or 0.0) > self.probe_feed_mm_per_min:
            raise ValueError(
                f"`second_feed_mm_per_min` is {self.second_feed_mm_per_min:g}, faster than the first touch at "
                f"{self.probe_feed_mm_per_min:g} (`probe_feed_mm_per_min`)"
            )
        return self

    @property
    def second(self) -> SecondTouch | None:
        """How points are touched again; None where they are touched once."""
        if self.second_feed_mm_per_min is None or self.second_back_off_mm is None:
            return None
        return SecondTouch(self.second_back_off_mm, self.second_feed_mm_per_min)


class ProbeTable(Table):
    """Lines in the control's code that turn the probe on and off and hold the spindle, several in one text."""

    on: str = ""
    """Lines in the control's code before the first touch, several in one text. `renishaw`: in place of `G65 P9832`."""
    off: str = ""
    """Lines after the way back. `renishaw`: in place of `G65 P9833`."""
    orient: str = ""
    """Lines behind the spindle's stop, to hold it in one direction (`M19`)."""


class CalibrationTable(Table):
    """As `trueloop probe calibrate` prints it."""

    effective_radius_mm: Positive
    """r₀ of the effective ball radius r₀ + a cos kθ + b sin kθ, θ the contact angle."""
    cosine_um: Finite = 0.0
    """a, lobing of the probe."""
    sine_um: Finite = 0.0
    """b."""
    lobes: Count = 3
    """k, legs of the probe's switch."""
    scatter_um: NotNegative = 0.0
    """Standard deviation of a touch."""
    radius_u_um: NotNegative = 0.0
    """Standard uncertainty of the ball's radius, in the direction that is known worst."""
    from_deg: Finite
    """The contact angles (of the outward normal, from +z towards +x) that it holds for begin here; touches more than 1°
    outside are refused.
    """
    to_deg: Finite
    """They end here."""

    @model_validator(mode="after")
    def _of_a_probe(self) -> "CalibrationTable":
        if not 0.0 < self.to_deg - self.from_deg <= 360.0:
            raise ValueError(f"`from_deg` {self.from_deg:g} to `to_deg` {self.to_deg:g} is not a range of 0 to 360°")
        largest_um = max(abs(self.cosine_um), abs(self.sine_um), self.scatter_um, self.radius_u_um)
        if largest_um > MOST_LOBING_UM:
            raise ValueError(
                f"{largest_um:g} µm of lobing, scatter or uncertainty is beyond {MOST_LOBING_UM:g} µm: another unit"
            )
        return self


class ProbeFile(Table):
    """A whole probe file."""

    stylus: StylusTable
    approach: ApproachTable = ApproachTable()
    program: ProgramTable = ProgramTable()
    probe: ProbeTable = ProbeTable()
    calibration: CalibrationTable | None = None

    @model_validator(mode="after")
    def _of_this_ball(self) -> "ProbeFile":
        ball_mm = options_from(Stylus, self).ball_radius_mm
        if self.calibration is not None:
            effective_mm, most_mm = self.calibration.effective_radius_mm, max(0.1, 0.2 * ball_mm)
            if abs(effective_mm - ball_mm) > most_mm:
                raise ValueError(
                    f"`calibration.effective_radius_mm` is {effective_mm:g}, more than {most_mm:g} mm off "
                    f"`stylus.ball_radius_mm` {ball_mm:g}: a diameter, another unit, or another stylus' calibration"
                )
        return self


@dataclass(frozen=True)
class ReadProbe:
    """A probe as values; `calibration` None when the file has none."""

    stylus: Stylus
    approach: Approach
    bar_radius_mm: float | None
    program: ProgramTable
    probe: ProbeTable
    calibration: BallCalibration | None


def read_probe(path: Path, allowance_mm: float = 0.0) -> ReadProbe:
    """Reads a probe file; touches are expected `allowance_mm` over the nominal surface. Raises PRB-FILE."""
    file = read_tables(path, ProbeFile, Code.PRB_FILE, hint="docs/probing.md lists every table and key of a probe file")
    return ReadProbe(
        stylus=options_from(Stylus, file),
        approach=options_from(Approach, file, allowance_mm=allowance_mm, second=file.program.second),
        bar_radius_mm=file.approach.bar_radius_mm,
        program=file.program,
        probe=file.probe,
        calibration=None if file.calibration is None else _calibration(file.calibration),
    )


def calibration_toml(calibration: BallCalibration) -> str:
    """The table that a calibration becomes in a probe file."""
    return "\n".join(
        [
            "[calibration]",
            f"effective_radius_mm = {calibration.effective_radius_mm:.6f}",
            f"cosine_um = {calibration.cosine_mm * UM_PER_MM:.3f}",
            f"sine_um = {calibration.sine_mm * UM_PER_MM:.3f}",
            f"lobes = {calibration.lobes}",
            f"scatter_um = {calibration.scatter_mm * UM_PER_MM:.3f}",
            f"radius_u_um = {calibration.radius_u_mm * UM_PER_MM:.3f}",
            f"from_deg = {math.degrees(calibration.lowest_rad):.1f}",
            f"to_deg = {math.degrees(calibration.highest_rad):.1f}",
            "",
        ]
    )


def _calibration(table: CalibrationTable) -> BallCalibration:
    return BallCalibration(
        effective_radius_mm=table.effective_radius_mm,
        cosine_mm=table.cosine_um / UM_PER_MM,
        sine_mm=table.sine_um / UM_PER_MM,
        lobes=table.lobes,
        scatter_mm=table.scatter_um / UM_PER_MM,
        lowest_rad=math.radians(table.from_deg),
        highest_rad=math.radians(table.to_deg),
        radius_u_mm=table.radius_u_um / UM_PER_MM,
    )
