"""The page of control charts: which characteristics alarm and why, charts of each, capability."""

from collections.abc import Iterator
from typing import Final

from trueloop.report.markup import esc, items, section, table
from trueloop.report.monitor.chart_figure import SHOWN, chart_figure
from trueloop.report.monitor.chart_lines import NAMED
from trueloop.report.monitor.chart_shapes import CapabilityShape, CharacteristicChartShape, ChartsShape, EpisodeShape
from trueloop.report.shell import figure_block, html_page, on_screen
from trueloop.report.texts.texts import ENGLISH, Texts

LARGEST: Final = 600_000
"""Bytes of figures on one page: what is beyond stands in the table alone."""


def chart_page(shown: ChartsShape, say: Texts = ENGLISH) -> str:
    """The page as HTML in one file."""
    figures, left_out = _figures(shown, say)
    note = say("{n} more characteristics stand in the table alone.", n=left_out) if left_out else ""
    of = say("errors of the parts as inspected") if shown.what == "value" else say("residuals after correction")
    body = (
        f'<header><p class="kicker">{say("trueloop · quality monitor")}</p><h1>{esc(shown.part_type)}</h1>'
        f'<p class="meta">{say("Control charts of {n} characteristics: {of}.", n=len(shown.characteristics), of=of)}'
        f"</p>{_verdict(shown, say)}{_how_to_read(shown, say)}</header>"
        + _alarms(shown, say)
        + section("capability", say("Characteristics"), _table(shown, say))
        + section(
            "charts", say("Charts"), on_screen(say), f'<div class="figures pairs">{figures}</div>',
            f"<p class='note'>{note}</p>" if note else "",
        )
        + _findings(shown)
    )  # fmt: skip
    return html_page(f"{esc(shown.part_type)} – {say('quality monitor')}", body, language=say.language)


def _verdict(shown: ChartsShape, say: Texts) -> str:
    alarms = [one for one in shown.characteristics if one.alarms]
    if not alarms:
        words = say("No alarm in {n} characteristics.", n=len(shown.characteristics))
    else:
        said = [f"{one.characteristic} ({one.alarms[-1].last})" for one in alarms]
        words = say("Alarm: {names}; in brackets the latest part that alarms.", names=esc(", ".join(said)))
    return f'<p class="verdict">{words}</p>'


def _how_to_read(shown: ChartsShape, say: Texts) -> str:
    words = say(
        "Grey ●: parts of the baseline, from which limits come; blue ●: others; ▲ alarm; dashed: limits; dotted: the "
        "tool was set. Individuals with ± 3 σ, moving ranges, EWMA of weight 0.2, CUSUM with an allowance of 0.5 σ "
        "(upwards above zero, downwards below)."
    )
    more = say(
        "Residuals are what memory did not expect of a part, in standard deviations of its expectation: with what was "
        "corrected taken into account."
    )
    return f"<p class='note'>{words}</p>" + (f"<p class='note'>{more}</p>" if shown.what == "residual" else "")


def _alarms(shown: ChartsShape, say: Texts) -> str:
    blocks = [block for one in shown.characteristics for block in _episodes(one, shown, say)]
    if not blocks:
        return ""
    note = say(
        "Probabilities compare what is known to have happened with a step at any part that nobody knows of; they hold "
        "for one change at a time. Sizes: how far the values moved, ± 95 %, if that is the cause."
    )
    return section("alarms", say("Alarms and what explains them"), *blocks, f"<p class='note'>{note}</p>")


def _episodes(one: CharacteristicChartShape, shown: ChartsShape, say: Texts) -> Iterator[str]:
    head = (say("cause"), say("what is known"), say("probability"), say("size ({unit})", unit=_unit(shown, say)))
    for episode in one.alarms:
        rows = [
            [say.note(cause.kind), esc(say.note(cause.words)), _percent(cause.probability, say), size]
            for cause in episode.causes
            if cause.probability >= NAMED
            for size in [f"{_number(cause.size, shown, say)} ± {_number(1.96 * cause.size_u, shown, say)}"]
        ]
        since = say("a step would begin at part {serial}", serial=esc(episode.since))
        rows.append([say("not known"), since, _percent(episode.unknown, say), ""])
        rows.append([say("chance"), say("nothing moved: a false alarm"), _percent(episode.chance, say), ""])
        yield f"<h3>{esc(one.characteristic)}: {_parts(episode, say)}</h3>{items(_meanings(episode, say))}"
        yield table(head, rows, words=(0, 1), stacks=True)


def _meanings(episode: EpisodeShape, say: Texts) -> Iterator[str]:
    yield from dict.fromkeys(f"{esc(alarm.chart)}: {esc(say.note(alarm.meaning))}" for alarm in episode.alarms)


def _parts(one: EpisodeShape, say: Texts) -> str:
    if one.first == one.last:
        return say("part {serial}", serial=esc(one.first))
    return say("parts {first} to {last}", first=esc(one.first), last=esc(one.last))


def _percent(share: float, say: Texts) -> str:
    return f"{say.number(100 * share, 0)} %"


def _unit(shown: ChartsShape, say: Texts) -> str:
    return say.um if shown.unit == "um" else "σ"


def _number(value: float, shown: ChartsShape, say: Texts) -> str:
    return say.size(value) if shown.unit == "um" else say.number(value, 2)


def _table(shown: ChartsShape, say: Texts) -> str:
    unit = _unit(shown, say)
    head = (
        say("characteristic"), say("parts"), say("mean ({unit})", unit=unit),
        say("σ short term<br>({unit})", unit=unit), say("σ of all<br>({unit})", unit=unit),
        "Cp", "Cpk", "Pp", "Ppk", say("alarms"),
    )  # fmt: skip
    rows = [_row(one, shown, say) for one in shown.characteristics]
    note = say(
        "Indices with their 95 % intervals [ISO 22514-2]: Cp and Cpk with the short-term deviation, Pp and Ppk with "
        "that of all parts; for values that are normally distributed."
    )
    remarks = items(
        f"<b>{esc(one.characteristic)}</b>: {esc(say.note(remark))}"
        for one in shown.characteristics
        for remark in one.remarks
    )
    return table(head, rows, words=(0,), name="monitor", stacks=True) + f"<p class='note'>{note}</p>" + remarks


def _row(one: CharacteristicChartShape, shown: ChartsShape, say: Texts) -> list[str]:
    found = one.capability
    mean = sum(part.value for part in one.parts) / len(one.parts)
    return [
        esc(one.characteristic),
        str(len(one.parts)),
        _number(mean, shown, say),
        _number(one.sigma, shown, say),
        "" if found is None else _number(found.sigma, shown, say),
        *(_index(found, name, say) for name in ("Cp", "Cpk", "Pp", "Ppk")),
        esc(", ".join(each.first for each in one.alarms)),
    ]


def _index(found: CapabilityShape | None, name: str, say: Texts) -> str:
    one = None if found is None else next(each for each in found.indices if each.name == name)
    if one is None or one.value is None or one.low is None or one.high is None:
        return ""
    return f"{say.number(one.value, 2)}<br>({say.number(one.low, 2)} … {say.number(one.high, 2)})"


def _figures(shown: ChartsShape, say: Texts) -> tuple[str, int]:
    """Figures of all characteristics as far as the page has room, and how many it has none for."""
    done: list[str] = []
    size = 0
    for k, one in enumerate(shown.characteristics):
        block = figure_block(f"chart-{k + 1}", chart_figure(one, shown, say), _caption(one, say), small=True)
        size += len(block.encode())
        if done and size > LARGEST:
            break
        done.append(block)
    return "".join(done), len(shown.characteristics) - len(done)


def _caption(one: CharacteristicChartShape, say: Texts) -> str:
    more = ""
    if len(one.parts) > SHOWN:
        more = say(", the latest {shown} of {all} parts", shown=SHOWN, all=len(one.parts))
    limits = [say.mm(limit, 4) for limit in (one.lower_limit_mm, one.upper_limit_mm) if limit is not None]
    between = f" ({' … '.join(limits)})" if limits else ""
    return f"<b>{esc(one.characteristic)}</b>, {say.mm(one.nominal_mm, 4)}{between} {say.mm_name}{more}"


def _findings(shown: ChartsShape) -> str:
    if not shown.findings:
        return ""
    return items(f"{esc(one.code)}: {esc(one.message)} – {esc(one.hint)}" for one in shown.findings)
