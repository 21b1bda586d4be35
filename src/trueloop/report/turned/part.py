"""A part that several edges cut, in one set-up or several: the answer by set-up and tool, as text, JSON and page."""

import json
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.record import sha256_of
from trueloop.geometry.feature import Feature, is_curved
from trueloop.loops.turned.part import EdgeCorrection, PartCorrection, SetupCorrection
from trueloop.report import style
from trueloop.report.markup import esc, html_page, items, section, table
from trueloop.report.program_diff import changed_lines, program_diff
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.characteristic_table import characteristic_table, characteristics_as_dicts
from trueloop.report.turned.contour_picture import COLOURS
from trueloop.report.turned.summary import feature_summaries
from trueloop.wording import all_of, wording


def answer_of(of: EdgeCorrection) -> str:
    """Returns `T3 wear X −0.024 mm (diameter), Z +0.004`, `T5 (left corner): by the contour`, or `…: not measured`."""
    if of.kept is not None:
        return wording("{tool}: not measured, correction {record} stays in force", tool=of.tool, record=of.kept.id)
    if of.correction is None:
        return wording("{tool}: not measured, left as programmed", tool=of.tool)
    if not of.correction.decision.by_offset:
        return wording("{tool}: by the contour", tool=of.tool)
    offset = of.correction.wear.answer.removeprefix(f"{of.correction.wear.called} ")
    return f"{of.tool} {offset}"


def answers(corrected: PartCorrection) -> list[str]:
    """Returns the answers of all edges in one line by set-up: `first: T1 wear X −0.024 mm (diameter), Z +0.004`."""
    return [_named(setup, "; ".join(map(answer_of, setup.edges))) for setup in corrected.setups]


def all_to_do(corrected: PartCorrection) -> list[str]:
    """Returns what to enter and what to run, by set-up."""
    return [_named(setup, _to_do(setup)) for setup in corrected.setups]


def all_notes(corrected: PartCorrection) -> list[str]:
    """Returns what to know of all set-ups together, and of the edges of each."""
    return [*corrected.notes, *(_named(setup, note) for setup in corrected.setups for note in _notes_of(setup))]


def _named(of: SetupCorrection, words: str) -> str:
    return wording("{setup}: {words}", setup=of.frame.name, words=words) if of.frame.name else words


def _to_do(of: SetupCorrection) -> str:
    entered = [
        answer_of(edge) for edge in of.edges if edge.correction is not None and edge.correction.decision.by_offset
    ]
    run = of.source_name if of.program is None else of.name
    if not entered:
        return wording("Run {program}.", program=run)
    return wording(
        "Enter at the control, once: {offsets}. Then run {program}.", offsets="; ".join(entered), program=run
    )


def _notes_of(of: SetupCorrection) -> list[str]:
    """Returns the notes on all edges of a set-up together."""
    return [*(_unmeasured(edge) for edge in of.edges if edge.correction is None), *of.notes]


def _unmeasured(of: EdgeCorrection) -> str:
    if of.kept is None:
        return wording(
            "{tool} cuts nothing that was measured: {features} stay as programmed.",
            tool=of.tool,
            features=all_of(of.features),
        )
    return wording(
        "{tool} cuts nothing that was measured: {features} stay as correction {record} has them.",
        tool=of.tool,
        features=all_of(of.features),
        record=of.kept.id,
    )


def part_as_dict(corrected: PartCorrection) -> dict[str, object]:
    """Converts a part to a dict: what to do, and by set-up frame, program and edges; without set-ups the program's."""
    if not corrected.in_setups:
        (only,) = corrected.setups
        return {"part": corrected.part, **_program(only)}
    return {
        "part": corrected.part,
        "record_id": corrected.record_id,
        "words": answers(corrected),
        "to_do": all_to_do(corrected),
        "uncut": list(corrected.uncut),
        "notes": all_notes(corrected),
        "characteristics": characteristics_as_dicts(corrected.characteristics),
        "setups": [_setup(setup) for setup in corrected.setups],
    }


def part_json(corrected: PartCorrection) -> str:
    """Returns the text of `part.json`."""
    return json.dumps(part_as_dict(corrected), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _setup(setup: SetupCorrection) -> dict[str, object]:
    frame = setup.frame
    return {
        "name": frame.name,
        "zero_at_z_mm": frame.zero_at_z_mm,
        "flipped": frame.flipped,
        "mirrored_z": frame.mirrored_z,
        "z_of_program": frame.words,
        "features": list(setup.features),
        **_program(setup),
    }


def _program(of: SetupCorrection) -> dict[str, object]:
    """Returns the actions, the programs by hash, and for each edge its features, answer and record."""
    return {
        "record_id": of.record_id,
        "words": "; ".join(map(answer_of, of.edges)),
        "to_do": _to_do(of),
        "program_to_run": of.source_name if of.program is None else of.name,
        "source_sha256": sha256_of(of.source),
        "program_sha256": sha256_of(of.source if of.program is None else of.program),
        "notes": _notes_of(of),
        "characteristics": characteristics_as_dicts(of.characteristics),
        "edges": [_edge(edge) for edge in of.edges],
    }


def _edge(of: EdgeCorrection) -> dict[str, object]:
    assert of.contour is not None  # a job's only tool has a report of its own
    edge, correction = of.contour.edge, of.correction
    answer = "not measured" if correction is None else "offset" if correction.decision.by_offset else "contour"
    entered = None if correction is None or correction.by_tool is None else correction.wear
    offset = None if entered is None else {**entered.as_dict(), "edge": edge.called.edge}
    return {
        "tool": of.tool,
        "number": edge.called.number,
        "edge": edge.called.edge,
        "corner": edge.corner,
        "name": edge.name,
        "nose_radius_mm": edge.nose_radius_mm,
        "features": list(of.features),
        "answer": answer,
        "words": answer_of(of),
        "tool_offset": offset,
        "record_id": of.kept.id if of.kept is not None else None if correction is None else correction.record.id,
    }


def part_page(corrected: PartCorrection, reports: Mapping[tuple[str, str], str], say: Texts = ENGLISH) -> str:
    """Writes the page of a part; `reports`: file name of each edge's own report, by set-up and tool."""
    title = say("{part} – correction {record}", part=esc(corrected.part), record=esc(corrected.record_id))
    notes = all_notes(corrected)
    sizes = [*corrected.characteristics, *(size for setup in corrected.setups for size in setup.characteristics)]
    verdict = "<br>".join(
        f"<strong>{esc('; '.join(say.note(part) for part in answer))}</strong><br>{esc(say.note(run))}"
        for answer, run in zip(_answers_in_parts(corrected), all_to_do(corrected), strict=True)
    )
    changed = [changes for setup in corrected.setups if (changes := _changes_of(setup, say)) or corrected.in_setups]
    body = (
        f"<header><h1>{esc(corrected.part)}</h1></header><p class='verdict'>{verdict}</p>"
        + (_setups(corrected, say) if corrected.in_setups else "")
        + section("edges", say("Errors of the features"), _features(corrected, reports, say))
        + (section("sizes", say("Sizes between edges"), characteristic_table(tuple(sizes), say)) if sizes else "")
        + (section("notes", say("Decisions"), items(esc(say.note(note)) for note in notes)) if notes else "")
        + (section("program", say("Changes to the program"), *changed) if changed else "")
    )
    return html_page(title, body, language=say.language)


def _answers_in_parts(corrected: PartCorrection) -> list[list[str]]:
    """The answers by set-up as sentences that can be translated: those of each edge, or, with set-ups, of all."""
    if corrected.in_setups:
        return [[answer] for answer in answers(corrected)]
    return [[answer_of(edge) for edge in corrected.edges]]


def _setups(corrected: PartCorrection, say: Texts) -> str:
    head = (say("set-up"), say("program"), say("its Z by z of the part"), say("features"))
    rows = [
        [
            esc(setup.frame.name),
            f"<code>{esc(setup.source_name)}</code>",
            esc(setup.frame.words),
            esc(", ".join(setup.features)),
        ]
        for setup in corrected.setups
    ]
    left = [["–", "", "", esc(", ".join(corrected.uncut))]] if corrected.uncut else []
    frames = table(head, [*rows, *left], words=(0, 1, 2, 3), name="frames", stacks=True)
    return section("setups", say("Set-ups"), frames, drawing(corrected))


def _features(corrected: PartCorrection, reports: Mapping[tuple[str, str], str], say: Texts) -> str:
    head = (say("feature"), say("tool"), say("touches"), say("before<br>worst {um}"), say("after<br>worst {um}"),
            say("largest U<br>{um}"), say("correction"))  # fmt: skip
    rows = list(_rows(corrected, reports, say))
    if not corrected.in_setups:
        return table(head, [row for _, row in rows], words=(0, 1, 6), name="features", stacks=True)
    named = [[esc(name), *row] for name, row in rows]
    return table((say("set-up"), *head), named, words=(0, 1, 2, 7), name="by-setup", stacks=True)


def _rows(
    corrected: PartCorrection, reports: Mapping[tuple[str, str], str], say: Texts
) -> Iterator[tuple[str, list[str]]]:
    """For every feature the name of its set-up, and its row."""
    for setup in corrected.setups:
        for edge in setup.edges:
            report = reports[setup.frame.name, edge.tool]
            yield from ((setup.frame.name, row) for row in _rows_of_edge(edge, report, say))


def _rows_of_edge(of: EdgeCorrection, report: str, say: Texts) -> Iterator[list[str]]:
    tool = esc(of.tool)
    if of.correction is None:
        words = say("not touched: left as programmed")
        if of.kept is not None:
            words = say("not touched: correction {record} stays in force", record=of.kept.id)
        for name in of.features:
            yield [esc(name), tool, "0", "", "", "", words]
        return
    link = f"<a href='{esc(report)}'>{tool}</a>"
    for summary in feature_summaries(of.correction, say):
        before, after = summary.figures.before_worst_um, summary.expected_um
        sizes = [say.error(before), say.error(after), say.size(summary.expanded_u_um)]
        yield [esc(summary.feature), link, str(summary.figures.touches), *sizes, esc(summary.correction)]


def _changes_of(of: SetupCorrection, say: Texts) -> str:
    """Returns the changes of the program; "" if it is run as given."""
    if of.program is None:
        return ""
    gone, come = changed_lines(of.source, of.program)
    counted = say("{n} lines in the place of {gone}, all others as they were.", n=come, gone=gone)
    return f"<p><code>{esc(of.name)}</code>: {counted}</p>" + program_diff(of.source, of.program, say)


WIDTH_PX: Final = 900.0
MARGIN_PX: Final = 30.0
ROW_PX: Final = 20.0
PLACES: Final = 33
"""Places along a curved feature."""


def drawing(corrected: PartCorrection) -> str:
    """Draws both halves of the section about the axis; below, a line for each set-up with where its +Z points."""
    of = {name: k for k, correction in enumerate(corrected.setups) for name in correction.features}
    ways = [(_places(feature), of.get(feature.name)) for feature in corrected.profile.features]
    every = np.concatenate([places for places, _ in ways])
    low, high, most = every[:, 1].min(), every[:, 1].max(), every[:, 0].max()
    scale = (WIDTH_PX - 2 * MARGIN_PX) / max(high - low, 2 * most)
    axis_px = MARGIN_PX + most * scale
    below_px = axis_px + most * scale + MARGIN_PX

    def points(places: Array, side: float) -> str:
        x, y = MARGIN_PX + (places[:, 1] - low) * scale, axis_px - side * places[:, 0] * scale
        return " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x, y, strict=True))

    body = [
        f'<polyline points="{points(places, side)}" fill="none" stroke="{_colour(k)}" stroke-width="3" '
        'stroke-linecap="round"/>'
        for places, k in ways
        for side in (1.0, -1.0)
    ]
    right_px = MARGIN_PX + (high - low) * scale
    body.append(
        f'<path d="M{MARGIN_PX / 3} {axis_px:.2f}H{right_px + 2 * MARGIN_PX / 3:.2f}" stroke="{style.SOFT}" '
        'stroke-dasharray="14 4 3 4"/>'
    )
    for k, correction in enumerate(corrected.setups):
        y = below_px + k * ROW_PX
        arrow = "←" if correction.frame.backwards else "→"
        body.append(
            f'<text x="{MARGIN_PX}" y="{y:.1f}" fill="{_colour(k)}">■ {esc(correction.frame.name)}: +Z {arrow}</text>'
        )
    height = below_px + len(corrected.setups) * ROW_PX
    return (
        f'<svg role="img" viewBox="0 0 {WIDTH_PX:.0f} {height:.0f}" width="100%" font-size="14" '
        f'xmlns="http://www.w3.org/2000/svg">{"".join(body)}</svg>'
    )


def _colour(setup: int | None) -> str:
    return style.SOFT if setup is None else COLOURS[setup % len(COLOURS)]


def _places(feature: Feature) -> Array:
    return feature.point_mm(np.linspace(0.0, feature.length_mm, PLACES if is_curved(feature) else 2))
