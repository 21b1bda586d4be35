"""The page of a series: what makes its parts wrong, and each error over the parts."""

from collections.abc import Sequence
from typing import Final

from trueloop.report.diagnosis.causes import causes_section, findings_section, unexplained_section, verdict
from trueloop.report.diagnosis.figures import SHOWN, series_figure
from trueloop.report.diagnosis.names import error_name, kind_name, mean_with_u
from trueloop.report.diagnosis.shapes import FeatureMeansShape, MeanShape, SeriesDiagnosisShape
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page, on_screen
from trueloop.report.texts.texts import ENGLISH, Texts

LARGEST: Final = 300_000
"""Bytes of figures on one page: what is beyond stands in the table alone."""


def series_page(series: SeriesDiagnosisShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    standards = sum(part.standard for part in series.parts)
    cut = len(series.parts) - standards
    counted = say("{parts} parts, {n} errors of features.", parts=cut, n=len(series.means))
    more = " " + say("{n} standard parts.", n=standards) if standards else ""
    body = (
        f'<header><p class="kicker">{say("trueloop · diagnosis of a series")}</p><h1>{esc(series.part_type)}</h1>'
        f'<p class="meta">{counted}{more}</p>{verdict(series.causes, cut, say, series.unexplained)}'
        f'<p class="note">{signs(say)}</p></header>'
        + unexplained_section(series.unexplained, say)
        + causes_section(series.causes, say)
        + _errors(series, say)
        + findings_section(series.findings, say)
    )
    return html_page(f"{esc(series.part_type)} – {say('diagnosis')}", body, language=say.language)


def signs(say: Texts) -> str:
    """Explains how errors are counted, and which device sees what."""
    return say(
        "Errors are along the outward normal, + where material is left on; a radius is a radius. The machine’s probe, "
        "corrected by the model of the machine, sees what the process did; a CMM or gauge sees what the model left too."
    )


def _errors(series: SeriesDiagnosisShape, say: Texts) -> str:
    if not series.means:
        return section("errors", say("Errors over the parts"), f"<p>{say('No part has errors of features.')}</p>")
    figures, left_out = _figures(series, say)
    reading = say(
        "○ machine’s probe, ◆ CMM or gauge, bars of 95 %; dotted: a tool was set. Mean ± its standard uncertainty; "
        "difference: CMM less machine, of parts that both saw, is what the model of the machine left."
    )
    note = say("{n} more errors stand in the table alone.", n=left_out) if left_out else ""
    return section(
        "errors",
        say("Errors over the parts"),
        means_table(series.means, say),
        f"<p class='note'>{reading}</p>",
        on_screen(say),
        f'<div class="figures pairs">{figures}</div>',
        f"<p class='note'>{note}</p>" if note else "",
    )


def means_table(means: Sequence[FeatureMeansShape], say: Texts) -> str:
    """Writes the table of mean and scatter of every error by device, µm."""
    head = (
        say("feature"), say("error"), say("parts"), say("machine’s probe<br>({um})"), say("CMM or gauge<br>({um})"),
        say("difference<br>({um})"), say("scatter over<br>the parts ({um})"),
    )  # fmt: skip
    rows = [
        (
            esc(error_name(one)),
            kind_name(one.kind, say),
            str(max(mean.parts for mean in (one.machine, one.cmm) if mean is not None)),
            mean_with_u(one.machine, say),
            mean_with_u(one.cmm, say),
            mean_with_u(one.difference, say),
            _scatter(one, say),
        )
        for one in means
    ]
    return table(head, rows, words=(0, 1), name="errors-table", stacks=True)


def _scatter(one: FeatureMeansShape, say: Texts) -> str:
    known = [mean.scatter_um for mean in (one.machine, one.cmm) if mean is not None and mean.scatter_um is not None]
    return " / ".join(say.size(value) for value in known) or "–"


def _figures(series: SeriesDiagnosisShape, say: Texts) -> tuple[str, int]:
    """Figures of the errors, those furthest from none first, as far as the page has room; and how many it has not."""
    done: list[str] = []
    size = 0
    for k, one in enumerate(sorted(series.means, key=_surprise, reverse=True)):
        block = figure_block(f"error-{k + 1}", series_figure(series.parts, one, say), _caption(series, one, say), True)
        size += len(block.encode())
        if done and size > LARGEST:
            break
        done.append(block)
    return "".join(done), len(series.means) - len(done)


def _surprise(one: FeatureMeansShape) -> float:
    return max(map(_ratio, (one.machine, one.cmm, one.difference)))


def _ratio(mean: MeanShape | None) -> float:
    return 0.0 if mean is None else abs(mean.mean_um) / max(mean.standard_u_um or 1.0, 0.1)


def _caption(series: SeriesDiagnosisShape, one: FeatureMeansShape, say: Texts) -> str:
    parts = sum(not part.standard for part in series.parts)
    more = say(", the latest {shown} of {all} parts", shown=SHOWN, all=parts) if parts > SHOWN else ""
    return f"<b>{esc(error_name(one))}</b>, {kind_name(one.kind, say)}{more}"
