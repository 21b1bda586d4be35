"""The tables of a job that state what was measured, and how its error is taken out."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.domain.option import Limits
from trueloop.formats.toml_tables import Count, Finite, In, Moment, NotNegative, Positive, Table, Vector, with_options
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging


@with_options("gauging", Gauging)
class GaugingTable(Table):
    """The measurements: touches of a probe, readings of gauges or measuring machines, or both.

    Ranges of repeated probing are those of [6811 §4.1]: 1.5 µm on diameters, 0.5 µm on faces.
    """

    touches: tuple[Path, ...] | Path | None = None
    """CSV of the touches after the semi-finish cut: `point`, `feature`, nominal and measured point or error, the unit
    in each column's name; also `note`, which is not read, and no others. Several files, as of a part that is probed in
    each of its set-ups, count as one. Left out, the job has `readings`.
    """
    readings: tuple[Path, ...] | Path = ()
    """One or several inspection files, in any format of [measurements.md](measurements.md): diameters, radii, lengths
    and angles of features, and points of a measuring machine, which are taken as touches. Of several parts in a file,
    `part.serial` chooses one. Characteristics that a file asks for are judged beside the job's.
    """
    readings_unit: Literal["mm", "inch"] | None = None
    """Unit of lengths in files of readings that do not state it: `"mm"` or `"inch"`."""
    readings_mapping: Path | None = None
    """TOML file that states what the columns, variables and names of files of readings mean
    ([measurements.md](measurements.md#tables-by-mapping)); `trueloop measure map` proposes one.
    """
    after_record: Path | None = None
    """Record (`record.json`) of the last correction of this process: measurements from before it are refused. A
    finished part is taken as cut with it, unless `programs.cut_with` states otherwise.
    """
    probe: Path | None = None
    """The probe's file (`docs/probing.md`): needed to plan touches, to write probing programs and to read their logs.
    """
    points: dict[str, Count] = Field(default_factory=dict)
    """How many points a feature gets when touches are planned, `{ dome = 20, "main-face" = 1 }`; left out with
    `spacing_mm`, the points of `touches` are taken.
    """
    spacing_mm: Positive | None = None
    """Every feature not named in `points` gets points at most this far apart."""
    measured_at: Moment | None = None
    """Date and time of the touches; from it their age is judged."""
    device: str = ""
    """The device that measured: probe, gauge or measuring machine, with its number. For the report and the record."""
    operator: str = ""
    """Who measured. For the report and the record."""
    program_sha256: str | None = None
    """SHA-256 of the finish program that the touches belong to: another program is refused."""
    finish_touches: Path | None = None
    """CSV of touches after an earlier corrected cut, to find a correction of reversed sign."""

    @property
    def touches_files(self) -> tuple[Path, ...]:
        """Those of `touches`, one or several."""
        return (self.touches,) if isinstance(self.touches, Path) else self.touches or ()

    @property
    def readings_files(self) -> tuple[Path, ...]:
        """Those of `readings`, one or several."""
        return (self.readings,) if isinstance(self.readings, Path) else self.readings

    @model_validator(mode="after")
    def _something_measured(self) -> "GaugingTable":
        if not self.touches_files and not self.readings_files:
            raise ValueError("`touches` or `readings` is missing: at least one of them is to be given")
        return self


class FeatureFitTable(Table):
    """Conditions on one feature's error curve: its knots, and error and slope of error at its ends."""

    knot_every: Annotated[Count | None, In("points")] = None
    """`knot_every` on this arc alone."""
    start_um: Finite | None = None
    """The error at the feature's start."""
    start_slope_um_per_mm: Finite | None = None
    """The slope of the error there, along the profile."""
    end_um: Finite | None = None
    """The error at the feature's end."""
    end_slope_um_per_mm: Finite | None = None
    """The slope of the error there."""


@with_options("compensation", Options, Limits)
class CompensationTable(Table):
    """How much of the error to take out, how, and what to refuse."""

    features: dict[str, FeatureFitTable] = Field(default_factory=dict)
    """Tables `[compensation.features.NAME]`, one a feature: see below."""
    nose_from: tuple[Path, ...] = ()
    """Job files of other parts cut with the same edge: their touches give the nose model, which serves an arc where
    leave-one-out prefers it.
    """
    cut_to_cut_um: NotNegative | None = None
    """Standard deviation of what moves a whole cut, along x and z each, but not from place to place of it (heat, the
    turret indexed for the probe, the edge): one part's touches cannot show it. The semi-finish and the finish cut both
    bring it. Left out together with the next key: 2 µm and 1.5 µm, a prior for turning in general that
    `src/trueloop/turned/fit/between_cuts.py` derives. `0` switches it off. Widens the predicted ±U (√2 times it, root
    of squares) and changes no correction.
    """
    cut_to_cut_along_um: NotNegative | None = None
    """As `cut_to_cut_um`, for the variation along the cut, over more than the distance of touches. Where one of the two
    is given, the other is 0 unless given too.
    """


Signals = dict[str, Finite] | Path
"""Values of a model's signals, or the log whose last row is meant."""


class MachineTable(Table):
    """The machine's own errors, to be corrected together with the process's: where the part stands, how warm it is."""

    model: Path
    """The model, as `trueloop machine fit` wrote it."""
    serial: str | None = None
    """Refuse a model of a machine with another serial number."""
    work_zero_mm: Vector | None = None
    """Machine coordinates of the program's zero, for a tool of no length, with all that is in force in the finish pass:
    work offset, G52, G92, TRANS. With set-ups it is stated in each of them.
    """
    tool_mm: Vector | None = None
    """The programmed point of the tool from the frame of the last axis, as `--tool`. Semi-finish and finish cut are
    made with this tool. With several tools it is stated in the table of each.
    """
    cutting: Signals = Field(default_factory=dict)
    """Signals of the model during the finish cut, `{ T1 = 24.0 }`, or the CSV log whose last row is meant."""
    semifinish_cut: Literal["uncompensated", "compensated"]
    """`"uncompensated"`: the touched surface carries the machine's error (its program is `programs.semifinish`, or as
    the finish program); `"compensated"`: the control took the error out, or a program that the job does not name. A
    `programs.semifinish` with trueloop's mark is followed word by word either way.
    """
    semifinish: Signals | None = None
    """Signals during the semi-finish cut; left out, those of `cutting`."""
    touched_on: Literal["machine", "cmm"]
    """`"machine"`: the control reported `gauging.touches`, which carry its error while probing; `"cmm"`: they are taken
    as they are, as `gauging.readings` are in any case.
    """
    probing: Signals | None = None
    """Signals while probing; required with touches taken on the machine."""
    probe_mm: Vector | None = None
    """The ball's centre from the frame of the last axis; required with touches taken on the machine."""
    probe_ball_radius_mm: NotNegative | None = None
    """Radius of the ball: where its centre was in the machine; left out, `gauging.ball_radius_mm`."""
    extrapolate: tuple[str, ...] = ()
    """Axes and signals that may leave the range of the model's data, `["T1"]`."""

    @model_validator(mode="after")
    def _probe_given(self) -> "MachineTable":
        if self.touched_on == "machine" and (self.probing is None or self.probe_mm is None):
            raise ValueError("touches taken on the machine need `probing` (temperatures) and `probe_mm`")
        return self
