"""What of a composed correction is the machine's and what the process's, touch by touch."""

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Composed, Correction
from trueloop.report.markup import esc, section, table
from trueloop.report.style import signed
from trueloop.units import UM_PER_MM

HEADINGS = (
    "feature", "point", "reported<br>µm", "part error<br>µm", "of it E of<br>the cut before µm", "COMP_MTG<br>µm",
    "COMP_PROC<br>µm", "composed<br>µm",
)  # fmt: skip


def composed_words(correction: Correction) -> str:
    """The ranges of both components at the touches, as plain text; empty where there is only COMP_PROC."""
    of = correction.composed
    if of is None:
        return ""
    mtg, proc = of.comp_mtg_mm, of.comp_proc_mm
    return f"At the touches, µm: COMP_MTG {_range(mtg)}; COMP_PROC {_range(proc)}; composed {_range(mtg + proc)}."


def composed_section(correction: Correction) -> str:
    """The section of the report, with a row a touch; empty where there is only COMP_PROC."""
    of = correction.composed
    if of is None:
        return ""
    return section(
        "composed",
        "Machine and process",
        f"<p>{esc(composed_words(correction))} COMP_MTG is the machine's, −E at the finish cut's temperatures; "
        "COMP_PROC the process's. Along the outward normal, + is away from the material.</p>",
        table(HEADINGS, _rows(correction, of), words=(0, 1), name="components"),
    )


def _rows(correction: Correction, of: Composed) -> list[list[str]]:
    touches, names = correction.touches, correction.profile.names
    numbers = UM_PER_MM * np.column_stack(
        [
            of.reported_mm, touches.error_mm, of.cut_in_mm, of.comp_mtg_mm, of.comp_proc_mm,
            of.comp_mtg_mm + of.comp_proc_mm,
        ]
    )  # fmt: skip
    return [
        [esc(names[feature]), esc(point), *map(signed, row)]
        for feature, point, row in zip(touches.feature_index, touches.point, numbers.tolist(), strict=True)
    ]


def _range(values_mm: Array) -> str:
    return f"{signed(values_mm.min() * UM_PER_MM)} to {signed(values_mm.max() * UM_PER_MM)}"
