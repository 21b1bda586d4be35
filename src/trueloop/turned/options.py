"""The user's options of the correction of a turned part."""

from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeAlias

from trueloop.domain.option import Limits, Option
from trueloop.turned.fit.between_cuts import PRIOR, BetweenCuts
from trueloop.turned.fit.options import FitOptions

Arcs: TypeAlias = Literal["auto", "lines", "arcs"]
By: TypeAlias = Literal["auto", "contour", "offset"]
Roughing: TypeAlias = Literal["moves", "stays"]


@dataclass(frozen=True)
class Options(FitOptions):
    """The options of a compensation: the choices of the fit, and these. Lengths in mm.

    `offset_is_diameter` says how the control reads tool offsets on X; None: as the program's X words. `tool` is the
    number of the finishing tool's offset, `tip` the orientation of the tip that the program moves without G41 or G42.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> half = trueloop.compensate(replace(job.inputs, options=trueloop.Options(weight=0.5)))
    >>> print(f"{1e3 * half.prediction.after_mm.max():.1f} µm")
    47.6 µm
    """

    between_cuts: BetweenCuts = PRIOR
    weight: Annotated[
        float,
        Option(
            "compensation.weight",
            "Share of the computed correction that is applied, over 0 to 1; on a new process begin with 0.5 to 0.75.",
            above=0,
            most=1,
        ),
    ] = 1.0
    chord_tolerance_mm: Annotated[
        float,
        Option(
            "compensation.chord_tolerance_um",
            "How far the moves that replace an arc may deviate from the compensated path.",
            above=0,
        ),
    ] = 0.0005
    arcs: Annotated[
        Arcs,
        Option(
            "compensation.arcs",
            'Replace arcs by `"lines"`, by tangent `"arcs"`, or by whichever needs fewer blocks (`"auto"`).',
        ),
    ] = "auto"
    errors_follow: Annotated[
        Literal["place", "nose"],
        Option(
            "compensation.errors_follow",
            '`"nose"` where the wear of the tool\'s nose is known to make the error: on arcs, where a corrected '
            "contour leans by e′ and is touched by another place of the nose, R e′² is taken out besides the error e, "
            '1 µm at most. With `"place"`, it is an uncertainty of R e′²/√3.',
        ),
    ] = "place"
    limits: Limits = field(default_factory=Limits)
    offset_is_diameter: bool | None = None
    tool: int | None = None
    tip: int | None = None
    by: Annotated[
        By,
        Option(
            "compensation.by",
            'What carries the correction: `"contour"`, the program\'s coordinates; `"offset"`, the tool\'s offset, '
            'whatever it leaves; `"auto"` asks the touches whether an offset is enough.',
        ),
    ] = "auto"
    roughing: Annotated[
        Roughing,
        Option(
            "programs.roughing",
            'What a roughing cycle on the corrected contour does: `"moves"` with it, so that the finish cut takes what '
            'it took when its errors were measured; `"stays"`: cuts what it cut before, and the finishing cycle gets a '
            "contour of its own.",
        ),
    ] = "moves"
