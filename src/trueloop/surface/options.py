"""The user's options for the correction of a surface."""

from dataclasses import dataclass
from typing import Annotated, Literal

from trueloop.domain.option import OF_SURFACES, Limits, Option
from trueloop.surface.deviations.alignment import SETUP_MM


@dataclass(frozen=True)
class SurfaceOptions:
    """How parts are compared with the nominal, how deviations are taken apart, how much is corrected.

    `best_fit`: what the set-up may have done is taken out. Lengths in mm; `least_supported` is a share of the face.
    """

    best_fit: bool = False
    farthest_mm: Annotated[
        float, Option("gauging.farthest_mm", "Points that deviate by more than this are refused.", above=0)
    ] = 1.0
    setup_mm: Annotated[
        float,
        Option(
            "gauging.setup_mm",
            "With a best fit: how far a part may sit off its datums, shifted or, as far as its points move, turned.",
            above=0,
        ),
    ] = SETUP_MM
    criterion: Annotated[
        Literal["likelihood", "randomness"],
        Option(
            "model.criterion",
            'How the number of control points is chosen: `"likelihood"`, or `"randomness"` as published.',
        ),
    ] = "likelihood"
    confidence: Annotated[float, Option("model.confidence", "Of every test.", above=0.5, below=1)] = 0.99
    exponent: Annotated[float, Option("model.exponent", "k of the weights d^-k of Moran's I.", above=0)] = 3.0
    cells: Annotated[
        tuple[int, int] | None,
        Option(
            "model.cells",
            "`[rows, columns]`: average scans over cells first: quicker above some ten thousand scattered points, and "
            "what a cell averages scatters less.",
            least=8,
            most=1000,
        ),
    ] = None
    exclude: Annotated[
        tuple[str, ...],
        Option("model.exclude", "Names of parts (file names without ending) to leave out of the pattern."),
    ] = ()
    own_mm: Annotated[
        float | None,
        Option(
            "model.part_to_part_um",
            "With fewer than three parts: how much the form of a part differs from the pattern, RMS. Left out: a fifth "
            "of what was measured.",
            above=0,
        ),
    ] = None
    target_mm: Annotated[
        float, Option("model.target_um", "Uncertainty by which the number of parts is judged.", above=0)
    ] = 1e-3
    weight: Annotated[
        float, Option("compensation.weight", "Share of the pattern to take away, over 0 to 1.", above=0, most=1)
    ] = 1.0
    least_supported: Annotated[
        float,
        Option(
            "compensation.min_supported_percent",
            "A face of which measurements support less is refused.",
            least=0,
            most=100,
        ),
    ] = 0.5
    tolerance_mm: Annotated[
        float, Option("compensation.tolerance_um", "How closely the corrected surface is refitted.", above=0)
    ] = 1e-4
    limits: Limits = OF_SURFACES
