"""One page that sets parts cut after a correction beside those before: a table, and maps on one colour scale."""

import json
from typing import Final

import numpy as np

from trueloop.loops.surface.compare import Comparison, Group, PartFigures, Spread
from trueloop.report.markup import esc, html_page, items, section, table
from trueloop.report.style import plain, signed
from trueloop.report.surface.maps import DeviationMap, caption, colour_range_um, flat
from trueloop.report.surface.summary import as_words
from trueloop.units import UM_PER_MM

PLACES: Final = 50
SIGN: Final = (
    "Errors are along the outward normals of the nominal surface: <b class='on'>+ is material left on</b> (red), "
    "<b class='off'>− is too much taken</b> (blue). One colour scale for all maps."
)


def compare_page(found: Comparison) -> str:
    """Writes the page of a comparison."""
    shown = [shown for pair in zip(maps(found, "before"), maps(found, "after"), strict=True) for shown in pair]
    range_um = colour_range_um(shown)
    figures = "".join(
        f'<figure id="{m.name}" class="small map">{flat(m, range_um)}<figcaption>{caption(m)}</figcaption></figure>'
        for m in shown
    )
    before, after = found.before, found.after
    title = f"{esc(after.name)} beside {esc(before.name)}"
    body = (
        '<header><p class="kicker">trueloop · parts before and after a correction</p>'
        f"<h1>{title}</h1><p class='meta'>before: {len(before.kept)} parts of {esc(before.name)} · after: "
        f"{len(after.kept)} parts of {esc(after.name)}</p>{_verdict(found)}<p class='note'>{SIGN}</p></header>"
        + section("figures", "Before and after", _both(found))
        + section("maps", "Maps", f'<div class="figures">{figures}</div>')
        + section("parts", "Parts", _parts(found))
        + (section("findings", "Findings", _findings(found)) if found.findings else "")
    )
    return html_page(f"{title} – before and after", body)


def maps(comparison: Comparison, which: str) -> list[DeviationMap]:
    """Returns the mean of the deterministic parts of the group `before` or `after`, as far as it was measured, and
    its worst part taken apart.
    """
    group: Group = getattr(comparison, which)
    measured = [part.separation.places for part in group.kept]
    u, v = (
        np.linspace(min(map(np.min, values)), max(map(np.max, values)), PLACES)
        for values in ([at.u for at in measured], [at.v for at in measured])
    )
    (u0, u1), (v0, v1) = comparison.surface.domain
    mean = DeviationMap(
        f"{which}-mean",
        f"{which}: deterministic, mean of {len(group.kept)} parts",
        comparison.surface.grid_mm(u0 + (u1 - u0) * u, v0 + (v1 - v0) * v),
        np.stack(np.meshgrid(u, v, indexing="ij"), axis=2),
        group.deterministic_mm(u, v),
    )
    part = group.kept[group.worst]
    apart, places, name = part.separation, part.separation.places, esc(part.deviations.name)
    grid = places.rows is not None and places.columns is not None
    shape = (len(places.rows), len(places.columns)) if grid else (len(places.u),)  # type: ignore[arg-type]
    uv_own = np.stack([places.u, places.v], axis=1).reshape(*shape, 2)
    own = {
        "measured": apart.measured_mm,
        "deterministic": apart.measured_mm - apart.random_mm,
        "random": apart.random_mm,
    }
    return [
        mean,
        *(
            DeviationMap(
                f"{which}-{kind}",
                f"{which}, worst part {name}: {kind}",
                places.points_mm.reshape(*shape, 3),
                uv_own,
                values.reshape(shape),
            )
            for kind, values in own.items()
        ),
    ]


def _verdict(comparison: Comparison) -> str:
    (_, before, after), *_ = rows_of(comparison)
    worst = [
        abs(group.figures[group.worst].measured.worst_mm) * UM_PER_MM for group in (comparison.before, comparison.after)
    ]
    return (
        f'<p class="verdict"><span class="stamp">Measured</span>The deterministic part went from '
        f"{plain(before.rms_mm * UM_PER_MM, 2)} to {plain(after.rms_mm * UM_PER_MM, 2)} µm RMS, the worst deviation "
        f"from {plain(worst[0])} to {plain(worst[1])} µm.</p>"
    )


def rows_of(comparison: Comparison) -> list[tuple[str, Spread, Spread]]:
    """Returns what the table compares: a name, before, after."""
    kinds = {
        "deterministic part": lambda part: part.deterministic,
        "random part": lambda part: part.random,
        "all deviations": lambda part: part.measured,
    }
    return [(name, comparison.before.over_all(of), comparison.after.over_all(of)) for name, of in kinds.items()]


def _both(comparison: Comparison) -> str:
    head = ("", "before, RMS (µm)", "range (µm)", "after, RMS (µm)", "range (µm)", "after ÷ before")
    rows = [
        (name, *_cells(before), *_cells(after), plain(after.rms_mm / before.rms_mm, 2) if before.rms_mm else "–")
        for name, before, after in rows_of(comparison)
    ]
    note = "<p class='note'>RMS over all parts; range from the least to the greatest of all.</p>"
    return table(head, rows, name="both-table") + note


def _parts(comparison: Comparison) -> str:
    head = ("", "part", "worst (µm)", "deterministic, RMS (µm)", "range (µm)", "random, RMS (µm)", "range (µm)")
    rows = [
        _compare_page_part(which, part)
        for which, group in (("before", comparison.before), ("after", comparison.after))
        for part in group.figures
    ]
    return table(head, rows, words=(0, 1), name="parts-table")


def _compare_page_part(which: str, part: PartFigures) -> tuple[str, ...]:
    worst = signed(part.measured.worst_mm * UM_PER_MM)
    return which, esc(part.name), worst, *_cells(part.deterministic), *_cells(part.random)


def _cells(spread: Spread) -> tuple[str, str]:
    low, high = (signed(value * UM_PER_MM) for value in (spread.low_mm, spread.high_mm))
    return plain(spread.rms_mm * UM_PER_MM, 2), f"{low} to {high}"


def _findings(comparison: Comparison) -> str:
    return items(f"{esc(f.code)}: {esc(f.message)} – {esc(f.hint)}" for f in comparison.findings)


def comparison_summary(comparison: Comparison) -> dict[str, object]:
    """Summarizes both groups in figures, and what was noticed in their parts."""
    groups = {"before": comparison.before, "after": comparison.after}
    return {
        which: {
            "name": group.name,
            "parts": [_part(part) for part in group.figures],
            "worst_part": group.figures[group.worst].name,
            **{name.replace(" ", "_"): _spread(spreads[side]) for name, *spreads in rows_of(comparison)},
        }
        for side, (which, group) in enumerate(groups.items())
    } | {"findings": as_words(comparison.findings)}


def comparison_json(comparison: Comparison) -> bytes:
    """Returns a comparison as the bytes of a JSON file."""
    return (json.dumps(comparison_summary(comparison), indent=1, ensure_ascii=False) + "\n").encode()


def comparison_lines(comparison: Comparison) -> list[str]:
    """Returns a comparison as lines of text."""
    groups = (comparison.before, comparison.after)
    counts = [f"{which}: {len(group.kept)} parts" for which, group in zip(("before", "after"), groups, strict=True)]
    lines = [_line("Deviation in µm", counts, "after ÷ before")]
    for name, before, after in rows_of(comparison):
        cells = [f"{s.rms_mm * UM_PER_MM:.2f} RMS" for s in (before, after)]
        lines.append(_line(name, cells, _share(before.rms_mm, after.rms_mm)))
        ranges = [f"{s.low_mm * UM_PER_MM:+.1f} to {s.high_mm * UM_PER_MM:+.1f}" for s in (before, after)]
        lines.append(_line("  range", ranges))
    worst = [group.figures[group.worst] for group in groups]
    cells = [f"{part.measured.worst_mm * UM_PER_MM:+.1f} ({part.name})" for part in worst]
    return [*lines, _line("worst (part)", cells, _share(*(part.measured.worst_mm for part in worst)))]


def _line(name: str, cells: list[str], share: str = "") -> str:
    return f"{name:<22}{cells[0]:>22}{cells[1]:>22}" + (f"{share:>16}" if share else "")


def _share(before_mm: float, after_mm: float) -> str:
    return f"{abs(after_mm / before_mm):.2f}" if before_mm else "–"


def _part(part: PartFigures) -> dict[str, object]:
    spreads = {name: _spread(getattr(part, name)) for name in ("measured", "deterministic", "random")}
    return {"name": part.name, **spreads}


def _spread(spread: Spread) -> dict[str, float]:
    names = {"rms_um": spread.rms_mm, "low_um": spread.low_mm, "high_um": spread.high_mm, "worst_um": spread.worst_mm}
    return {name: value * UM_PER_MM for name, value in names.items()}
