"""What several edges are corrected by, in one program: the answer by tool, as text, as JSON and as a page."""

import json
from collections.abc import Iterator, Sequence

from trueloop.domain.judged import Judged
from trueloop.domain.record import sha256_of
from trueloop.loops.turned.joint import Joint, OfEdge
from trueloop.report.markup import esc, items, section, table
from trueloop.report.program_diff import changed_lines, program_diff
from trueloop.report.shell import html_page
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.characteristic_table import characteristic_table
from trueloop.report.turned.characteristics import characteristics_as_dicts
from trueloop.report.turned.features import feature_summaries
from trueloop.wording import all_of, wording


def answer_of(of: OfEdge) -> str:
    """`T3 wear X −0.024 mm (diameter), Z +0.004`, `T5 (left corner): by the contour`, or `…: not measured`."""
    if of.correction is None:
        return wording("{tool}: not measured, left as programmed", tool=of.tool)
    if not of.correction.decision.by_offset:
        return wording("{tool}: by the contour", tool=of.tool)
    offset = of.correction.wear.answer.removeprefix(f"{of.correction.wear.called} ")
    return f"{of.tool} {offset}"


def answer_words(joint: Joint) -> str:
    """The answers of all edges in one line."""
    return "; ".join(answer_of(one) for one in joint.edges)


def to_do(joint: Joint, name: str) -> str:
    """What to enter and what to run."""
    entered = [
        answer_of(one) for one in joint.edges if one.correction is not None and one.correction.decision.by_offset
    ]
    run = joint.source_name if joint.program is None else name
    if not entered:
        return wording("Run {program}.", program=run)
    return wording(
        "Enter at the control, once: {offsets}. Then run {program}.", offsets="; ".join(entered), program=run
    )


def notes_of(joint: Joint) -> list[str]:
    """What to know of all edges together."""
    unmeasured = [
        wording(
            "{tool} cuts nothing that was measured: {features} stay as programmed.",
            tool=one.tool,
            features=all_of(one.contour.profile.names),
        )
        for one in joint.edges
        if one.correction is None
    ]
    return [*unmeasured, *joint.notes]


def joint_as_dict(joint: Joint, name: str) -> dict[str, object]:
    """For machines: what to do, the programs by hash, and by edge what it cuts, its answer and its record."""
    return {
        "part": joint.part,
        "record_id": joint.record_id,
        "words": answer_words(joint),
        "to_do": to_do(joint, name),
        "program_to_run": joint.source_name if joint.program is None else name,
        "source_sha256": sha256_of(joint.source),
        "program_sha256": sha256_of(joint.source if joint.program is None else joint.program),
        "notes": notes_of(joint),
        "characteristics": characteristics_as_dicts(joint.characteristics),
        "edges": [_edge(one) for one in joint.edges],
    }


def joint_json(joint: Joint, name: str) -> str:
    """Returns the text of `part.json`."""
    return json.dumps(joint_as_dict(joint, name), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _edge(of: OfEdge) -> dict[str, object]:
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
        "features": list(of.contour.profile.names),
        "answer": answer,
        "words": answer_of(of),
        "tool_offset": offset,
        "record_id": None if correction is None else correction.record.id,
    }


def joint_page(joint: Joint, name: str, reports: dict[str, str], say: Texts = ENGLISH) -> str:
    """The page of a part that several edges cut; `reports`: file name of each edge's own report, by its tool."""
    title = say("{part} – correction {record}", part=esc(joint.part), record=esc(joint.record_id))
    notes = notes_of(joint)
    body = (
        f"<header><h1>{esc(joint.part)}</h1></header>"
        f"<p class='verdict'><strong>{esc('; '.join(say.note(answer_of(one)) for one in joint.edges))}</strong><br>"
        f"{esc(say.note(to_do(joint, name)))}</p>"
        + section("edges", say("Errors of the features"), _features(joint, reports, say))
        + sizes_section(joint.characteristics, say)
        + (section("notes", say("Decisions"), items(esc(say.note(note)) for note in notes)) if notes else "")
        + (
            section("program", say("Changes to the program"), changed)
            if (changed := changes_of(joint, name, say))
            else ""
        )
    )
    return html_page(title, body, language=say.language)


def sizes_section(sizes: Sequence[Judged], say: Texts) -> str:
    """The sizes between features of two edges; those of one are in its own report."""
    return section("sizes", say("Sizes between edges"), characteristic_table(tuple(sizes), say)) if sizes else ""


def _features(joint: Joint, reports: dict[str, str], say: Texts) -> str:
    head = (say("feature"), say("tool"), say("touches"), say("before<br>worst {um}"), say("after<br>worst {um}"),
            say("largest U<br>{um}"), say("correction"))  # fmt: skip
    rows = [row for one in joint.edges for row in rows_of_edge(one, reports[one.tool], say)]
    return table(head, rows, words=(0, 1, 6), name="features", stacks=True)


def rows_of_edge(of: OfEdge, report: str, say: Texts) -> Iterator[list[str]]:
    """A row for every feature that an edge cuts; `report` is the file name of its own."""
    tool = esc(of.tool)
    if of.correction is None:
        for name in of.contour.profile.names:
            yield [esc(name), tool, "0", "", "", "", say("not touched: left as programmed")]
        return
    link = f"<a href='{esc(report)}'>{tool}</a>"
    for one in feature_summaries(of.correction, say):
        before, after = one.figures.before_worst_um, one.expected_um
        sizes = [say.error(before), say.error(after), say.size(one.expanded_u_um)]
        yield [esc(one.feature), link, str(one.figures.touches), *sizes, esc(one.correction)]


def changes_of(joint: Joint, name: str, say: Texts) -> str:
    """What is changed in the program; "" where it is run as given."""
    if joint.program is None:
        return ""
    gone, come = changed_lines(joint.source, joint.program)
    counted = say("{n} lines in the place of {gone}, all others as they were.", n=come, gone=gone)
    return f"<p><code>{esc(name)}</code>: {counted}</p>" + program_diff(joint.source, joint.program, say)
