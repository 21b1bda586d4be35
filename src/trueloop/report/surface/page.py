"""One page per surface: what was measured, what repeats, what is random, the pattern, and what is predicted after."""

import json
import math
from collections.abc import Sequence
from itertools import chain
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.surface.figures import headline, unsupported_at
from trueloop.loops.surface.surface import Part, SurfaceCorrection, SurfaceModel, maps_of
from trueloop.report.markup import esc, html_page, items, section, table
from trueloop.report.style import plain, signed
from trueloop.report.surface.maps import (
    DeviationMap,
    between_parts,
    caption,
    colour_range_um,
    flat,
    map_of_part,
    maps_of_part,
    part_choice,
    sheet,
)
from trueloop.surface.compensation.shift import WrittenPattern
from trueloop.surface.on_face import MAPS
from trueloop.surface.pattern.pattern import PartMaps, part_maps
from trueloop.units import UM_PER_MM

WIDTH: Final = 960
HEIGHT: Final = 520


def space_figure(maps: list[DeviationMap]) -> str:
    """Writes the figure and the list of maps to choose from (HTML); colours and parts are those of `part_choice`."""
    drawn = [shown.thinned for shown in maps]
    places = list({_key(shown): shown for shown in drawn}.values())
    data = {"places": [_places(shown) for shown in places], "maps": [_numbers(shown, places) for shown in drawn]}
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    options = "".join(f'<option value="{shown.name}">{shown.title}</option>' for shown in maps)
    return (
        f'<figure id="space"><p><label>On the surface <select>{options}</select></label></p>'
        f'<canvas width="{2 * WIDTH}" height="{2 * HEIGHT}" tabindex="0"></canvas>'
        f'<script type="application/json">{text}</script><figcaption>Turn it with the mouse or the arrow keys; '
        "point at a place for its error. Axes in mm.</figcaption></figure>"
    )


def _key(shown: DeviationMap) -> bytes:
    """Maps of one part share their places."""
    return shown.points_mm.tobytes()


def _places(shown: DeviationMap) -> dict[str, object]:
    """`rows` is 0 where places are scattered."""
    rows = shown.error_mm.shape[0] if shown.error_mm.ndim == 2 else 0
    return {"rows": rows, "xyz": shown.points_mm.reshape(-1, 3).T.round(3).tolist()}


def _numbers(shown: DeviationMap, places: list[DeviationMap]) -> dict[str, object]:
    at = [_key(place) for place in places].index(_key(shown))
    error = [None if math.isnan(e) else round(e, 2) for e in (shown.error_mm.ravel() * UM_PER_MM).tolist()]
    return {"name": shown.name, "at": at, "error": error}


SIGN: Final = (
    "Errors are along the outward normals of the nominal surface: <b class='on'>+ is material left on</b> (red), "
    "<b class='off'>− is too much taken</b> (blue). One colour scale for all maps."
)
RIDGES: Final = (
    "The 95 % band is that of a smooth pattern and does not cover the ridges (scallops) that the program itself leaves "
    "between its passes: on the virtual mill of the examples 81 to 87 % of places of the true surface are inside it, "
    "and 87 to 94 % with these ridges taken off (docs/surface.md, Ridges)."
)


def surface_page(
    name: str, model: SurfaceModel, correction: SurfaceCorrection | None = None, written: Sequence[WrittenPattern] = ()
) -> str:
    """Writes the page of one surface's pattern, of its correction, if any, and of the pattern `written` as CAD."""
    parts = [own for own, _ in maps_of(model)]
    own, drawn = [maps_of_part(model, part) for part in parts], _arranged(model, parts[0])
    range_um = colour_range_um([*drawn, *chain.from_iterable(own)])
    choice = part_choice(own, [part.deviations.name for part in model.parts], range_um)
    figures = "".join(_figure(m, range_um) for m in drawn)
    noticed = correction.findings if correction else model.findings
    findings = items(f"{esc(f.code)}: {esc(f.message)} – {esc(f.hint)}" for f in noticed)
    body = (
        '<header><p class="kicker">trueloop · machining pattern of a surface</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{_summary(model)}</p>"
        f"{_prediction(model)}<p class='note'>{RIDGES}</p><p class='note'>{SIGN}</p></header>"
        + section("maps", "Maps", choice, f'<div class="figures">{figures}</div>', space_figure(drawn))
        + section("parts", "Parts", _parts(model))
        + (section("cad", "Pattern as CAD", _cad(written)) if written else "")
        + (section("correction", "Correction", _correction(correction)) if correction else "")
        + (section("findings", "Findings", findings) if noticed else "")
    )
    return html_page(f"{esc(name)} – machining pattern", body, script="surface.js")


def maps(model: SurfaceModel) -> list[DeviationMap]:
    """Returns the maps of the page: the first part's own, the pattern, its variability, and the prediction."""
    first = model.parts[0]
    return _arranged(model, part_maps(model.pattern, first.separation, first.deviations.name, model.options.weight))


def _arranged(model: SurfaceModel, first: PartMaps) -> list[DeviationMap]:
    at = np.linspace(0.0, 1.0, MAPS)
    (u0, u1), (v0, v1) = model.surface.domain
    points = model.surface.grid_mm(u0 + (u1 - u0) * at, v0 + (v1 - v0) * at)
    uv, pattern = np.stack(np.meshgrid(at, at, indexing="ij"), axis=2), model.pattern
    there = model.on_face.square(MAPS)
    bare = there & unsupported_at(pattern, *np.moveaxis(uv, 2, 0))
    *apart, predicted = maps_of_part(model, first)

    def whole(name: str, title: str, values_mm: Array) -> DeviationMap:
        return DeviationMap(
            name=name, title=title, points_mm=points, uv=uv, error_mm=np.where(there, values_mm, np.nan), bare=bare
        )

    return [
        *apart,
        whole("pattern", f"Pattern of {pattern.of_parts}", pattern.mean.grid_mm(at, at)),
        whole("uncertainty", "± uncertainty of the pattern (95 %)", pattern.uncertainty_grid_mm(at, at)),
        map_of_part(model, first, "variability", between_parts(pattern)),
        predicted,
    ]


def maps_picture(model: SurfaceModel) -> str:
    """All maps flat, as one SVG file for print.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3])
    >>> found = trueloop.pattern_of_parts(job, trueloop.model_of(given.surface, given.parts, given.options))
    >>> trueloop.maps_picture(found).startswith("<svg")  # IPython.display.SVG shows it
    True
    """
    return sheet(maps(model))


def _figure(shown: DeviationMap, range_um: float) -> str:
    drawn = flat(shown, range_um)
    return f'<figure id="{shown.name}" class="small map">{drawn}<figcaption>{caption(shown)}</figcaption></figure>'


def _summary(model: SurfaceModel) -> str:
    kinds = sorted({part.deviations.alignment.kind for part in model.parts})
    words = {"datum": "datum-bound: location and orientation are among the errors", "best fit": "best fit: form alone"}
    return (
        f"{model.pattern.of_parts} · {'; '.join(words[kind] for kind in kinds)} · "
        f"pattern of {esc(model.pattern.size)} "
        f"· random part {plain(model.pattern.sigma_mm * UM_PER_MM, 2)} µm (one standard deviation)"
    )


def _prediction(model: SurfaceModel) -> str:
    figures = model.figures
    worst, unsure, keeps = (
        value_mm * UM_PER_MM for value_mm in (figures.largest_mm, figures.uncertainty_mm, figures.next_part_mm)
    )
    weight = model.options.weight
    left = f"{plain((1 - weight) * worst)} µm of it at most (weight {weight:g}), and " if weight < 1 else ""
    return (
        f'<p class="verdict"><span class="stamp">Prediction</span>The pattern reaches {plain(worst)} µm and is known '
        "to "
        f"± {plain(unsure, 2)} µm (95 %, mean over the face). A next part corrected by it keeps {left}± "
        f"{plain(keeps, 2)} µm of its own, and its random part. For ± "
        f"{plain(model.options.target_mm * UM_PER_MM, 2)} µm "
        f"{model.parts_needed} parts are needed.</p>{_support(model)}"
    )


def _support(model: SurfaceModel) -> str:
    support = headline(model.figures)
    if not support:
        return ""
    return (
        f'<p class="verdict"><span class="stamp">Support</span>{esc(support)}. Hatched on the '
        "maps of the pattern and of its uncertainty.</p>"
    )


def _parts(model: SurfaceModel) -> str:
    head = (
        "part", "controls", "Moran’s I", "expected", "p", "p shuffled", "Geary’s C", "expected", "Lilliefors p",
        "K–S p", "random σ (µm)", "errors (µm)",
    )  # fmt: skip
    rows = [_row(part) for part in model.parts]
    note = (
        "<p class='note'>Expected: Moran’s I where what is left has no order in space. p: that residuals so alike come "
        "by chance, by the moments of regression residuals; shuffled: by permutation. Geary’s C is below what is "
        "expected where neighbours are alike. Kolmogorov–Smirnov takes mean and scatter for known, which they are not: "
        "Lilliefors decides.</p>"
    )
    return table(head, rows, name="parts-table") + note


def _row(part: Part) -> tuple[str, ...]:
    apart, trial = part.separation, part.separation.chosen
    low, high = (float(f(apart.measured_mm)) * UM_PER_MM for f in (np.min, np.max))
    return (
        esc(part.deviations.name),
        esc(trial.size),
        plain(trial.moran_i, 4),
        plain(trial.null.expected, 4),
        plain(trial.moran_p, 3),
        plain(part.permutation_p, 3),
        plain(apart.geary_c, 3),
        plain(apart.expected_geary_c, 3),
        plain(trial.normality.lilliefors_p, 3),
        plain(trial.normality.ks_p, 3),
        plain(apart.sigma_mm * UM_PER_MM, 2),
        f"{signed(low)} to {signed(high)}",
    )


def _at_least_a_nanometre(um: float) -> str:
    return plain(um, 3) if um >= 0.001 else "&lt; 0.001"


def _cad(written: Sequence[WrittenPattern]) -> str:
    head = ("files", "pattern magnified", "degree", "control points", "deviation (µm)")
    rows = [
        (
            ", ".join(f'<a href="{esc(file)}">{esc(file)}</a>' for file in of.files),
            f"× {of.factor:g}",
            " × ".join(str(degree) for degree in of.made.surface.degrees),
            " × ".join(str(count) for count in of.made.surface.control_mm.shape[:2]),
            _at_least_a_nanometre(of.made.worst_mm * UM_PER_MM),
        )
        for of in written
    ]
    note = (
        "<p class='note'>Nominal surface and pattern together, the pattern magnified as stated; not to be cut. "
        "Deviation: how far the written surface deviates at most from the sampled nominal surface and pattern.</p>"
    )
    return table(head, rows, name="cad-table") + note


def _correction(correction: SurfaceCorrection) -> str:
    surface, program = correction.surface, correction.program
    lines = [
        f"surface moved by up to {plain(surface.largest_shift_mm * UM_PER_MM)} µm, refitted to "
        f"{plain(surface.worst_mm * UM_PER_MM, 3)} µm with {surface.surface.control_mm.shape[0]} × "
        f"{surface.surface.control_mm.shape[1]} control points"
    ]
    if correction.in_force_mm:
        lines.append(
            f"of which up to {plain(correction.in_force_mm * UM_PER_MM)} µm were in force when the parts were cut"
        )
    if program is not None:
        lines.append(
            f"program: {program.cutting_moves} moves cut the surface, {program.new_blocks} blocks were put in, ends "
            f"moved by up to {plain(program.largest_mm * UM_PER_MM)} µm"
        )
    return items(lines)
