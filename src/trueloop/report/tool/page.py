"""One page of an edge: its life, its errors over contact angle with band and parts, its setting, its events."""

from trueloop.domain.edge_names import edge_name, time
from trueloop.report.markup import esc, fields, items, section, table
from trueloop.report.shell import figure_block, html_page
from trueloop.report.tool.figures import error_figure, form_figure, transfer_figure, types_figure
from trueloop.report.tool.shown import ShownEdge
from trueloop.report.tool.summary import NOTHING, cut_words, event_line, heads_of, rows_of, setting_words

ERROR = (
    "Finish error of a next part of each type in the present setting, had nothing been corrected, with its 95 % band; "
    "dots: finish inspections with the correction added, as in the present setting. Grey: angles that no part was "
    "touched at."
)
FORM = (
    "Form of the edge with its 95 % band; dots: touches after the semi-finish cut, less what setting, part type and "
    "part add. Form and setting share an offset: each alone is known less well than their sum."
)
TRANSFER = (
    "What the finish cut leaves more than the semi-finish cut, with its 95 % band; dots: finish inspections with the "
    "correction added, less what all else adds."
)
TYPES = "What the finish cut of each part type has besides: its own setting, and its own share of the finish cut."


def edge_page(shown: ShownEdge) -> str:
    """The page as HTML; it needs no other file."""
    name, life = esc(edge_name(shown.life.edge)), shown.life
    nose = life.edge.tool.corner_radius_mm
    end = life.ended
    head = (
        '<header><p class="kicker">trueloop · what an edge has taught</p>'
        f"<h1>{name}</h1><p class='meta'>{esc(cut_words(shown))}</p>"
        "<p class='note'>Errors in µm along the normal, positive where material is left on. The contact angle is 90° "
        "on a cylinder, 0° on a face that looks along +z.</p></header>"
    )
    rows = [
        ("Machine", "" if life.machine is None else esc(life.machine.name)),
        ("Nose radius", "" if nose is None else f"{nose:g} mm"),
        ("Mounted", time(life.began)),
        ("Set", time(life.set_at)),
        ("Ended", "" if end is None else f"{end.kind} {time(end.at)}"),
    ]
    body = head + fields(rows) + _learnt(shown)
    body += section("events", "Events", items(esc(event_line(event)) for event in life.events))
    if shown.findings:
        body += section("findings", "Findings", items(f"{esc(f.code)}: {esc(f.message)}" for f in shown.findings))
    return html_page(f"{name} – edge", body)


def _learnt(shown: ShownEdge) -> str:
    found = shown.learnt
    if found is None:
        return section("learnt", "Learnt", "<p>Nothing yet: " + NOTHING + ".</p>")
    said = f"<p>From {found.parts} parts, {found.inspected} of them inspected after the finish cut.</p>"
    figures = [figure_block("error", error_figure(shown, found), ERROR)]
    figures.append(figure_block("form", form_figure(shown, found), FORM))
    if found.inspected:
        figures.append(figure_block("transfer", transfer_figure(shown, found), TRANSFER))
    figures.append(figure_block("types", types_figure(shown, found), TYPES))
    rows = [tuple(map(esc, row)) for row in rows_of(shown, found)]
    return (
        section("learnt", "Error over contact angle", said, f"<p>{esc(setting_words(found))}</p>", *figures)
        + section("values", "Values", table(tuple(map(esc, heads_of(found))), rows, words=()))
    )  # fmt: skip
