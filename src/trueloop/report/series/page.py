"""The page of a series: what each characteristic does from part to part, before and after correction.

One characteristic over the parts: errors before and after correction, bands, weights; tool and alarms marked.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, Final

from trueloop.domain.proposal import Effect
from trueloop.report import style
from trueloop.report.markup import as_room_allows, esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.series.values import CharacteristicSeriesShape, PartShape, SeriesShape
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM
from trueloop.wording import Wording

PROPOSAL_WIDTH: Final = 480
"""As wide as a telephone shows it."""
PROPOSAL_HEIGHT: Final = 300
APART: Final = 0.16
"""How far both marks of a characteristic stand from its middle."""
LONGEST: Final = 60
"""Letters of all names below the axis together."""


def proposal_figure(effects: Sequence[Effect], say: Texts = ENGLISH) -> Figure:
    """Draws ● without the proposal, ◆ with it; bars hold 95 % of parts. Errors are actual less nominal size: their sign
    does not tell whether material is left on, which is less in a bore that is too large.
    """
    before, after = ([effect.error_before_mm for effect in effects], [effect.error_after_mm for effect in effects])
    u = [NORMAL_95 * effect.standard_u_mm for effect in effects]
    seen = [UM_PER_MM * (e + sign * w) for e, w in zip(before + after, u + u, strict=True) for sign in (-1, 1)]
    low, high = style.padded(seen)
    data = [
        _proposal_marks(-APART, before, u, say, color=BEFORE, symbol="circle", size=9),
        _proposal_marks(APART, after, u, say, color=style.AFTER, symbol="diamond", size=11),
    ]
    layout = style.layout(
        PROPOSAL_WIDTH,
        PROPOSAL_HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("characteristic"), 0.5, len(effects) + 0.5) | _names(effects),
        yaxis=style.axis(say("error ({um})"), low * say.per_um, high * say.per_um, 6),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _names(effects: Sequence[Effect]) -> dict[str, list[object]]:
    most = max(LONGEST // len(effects), 3)
    names = [one if len(one) <= most else f"{one[: most - 1]}…" for one in (each.characteristic for each in effects)]
    return {"tickvals": [k + 1 for k in range(len(effects))], "ticktext": [style.label(name) for name in names]}


def _proposal_marks(
    shift: float, errors_mm: Sequence[float], u_mm: Sequence[float], say: Texts, **marker: object
) -> Trace:
    um = [one * UM_PER_MM * say.per_um for one in errors_mm]
    bars = [one * UM_PER_MM * say.per_um for one in u_mm]
    hover = [
        f"{say.error(UM_PER_MM * e)} ± {say.size(UM_PER_MM * w)} {say.um}" for e, w in zip(errors_mm, u_mm, strict=True)
    ]
    x = [k + 1 + shift for k in range(len(um))]
    error_y = {"type": "data", "array": bars, "color": style.INK, "thickness": 1.2, "width": 3}
    return style.dots(x, um, hover, **marker) | {"error_y": error_y}


WIDTH: Final = 480
"""As wide as a telephone shows it; on a screen two stand side by side."""
HEIGHT: Final = 330
SHOWN: Final = 60
"""The latest parts of a longer series."""
ERRORS: Final = (0.34, 1.0)
WEIGHTS: Final = (0.0, 0.24)
"""Shares of the height: errors above, weights below."""
BEFORE: Final = style.SOFT
AFTER: Final = style.IN
ALARM: Final = style.OUT
LIMIT: Final = style.INK
TICKS: Final = 8


def series_figure(series: CharacteristicSeriesShape, say: Texts = ENGLISH) -> Figure:
    """Draws ○ before and ● after correction with the band expected of ●, limits where they are near, ▲ alarms.

    Colours are those of Okabe and Ito; shapes say the same, so that none depends on colour.
    """
    parts = series.parts[-SHOWN:]
    scale = say.per_um
    low, high = style.padded(_seen(parts), 0.08, 1.0)
    x = [float(k) for k in range(1, len(parts) + 1)]
    data = [
        *_bands(x, parts, scale),
        *_limits(series, x, (low, high), scale),
        *_tool_set(x, parts, (low * scale, high * scale)),
        *_marks(x, parts, say),
        *_weights(x, parts, say),
    ]
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("part"), 0.4, len(parts) + 0.6, **_serials(parts)),
        yaxis=style.axis(say("error ({um})"), low * scale, high * scale, 6, domain=list(ERRORS)),
        yaxis2=style.axis(say("weight"), 0.0, 1.05, 2, domain=list(WEIGHTS)),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _seen(parts: Sequence[PartShape]) -> list[float]:
    """The range of the axis: marks, and bands as far as those of parts after the first go."""
    marks = [value for part in parts for value in (part.before_um, part.after_um)]
    bands = [
        value
        for part in parts[1:]
        if part.expected_um is not None and part.band_um is not None
        for value in (part.expected_um - part.band_um, part.expected_um + part.band_um)
    ]
    return marks + bands


def _serials(parts: Sequence[PartShape]) -> dict[str, Any]:
    """Serial numbers at some of the parts, no more than are legible."""
    step = max(1, -(-len(parts) // TICKS), max(len(part.serial) for part in parts) * len(parts) // 45)
    at = list(range(0, len(parts), step))
    return {"tickvals": [k + 1 for k in at], "ticktext": [style.label(parts[k].serial) for k in at]}


def _bands(x: Sequence[float], parts: Sequence[PartShape], scale: float) -> list[Trace]:
    """Draws a bar for every part, from the lower to the upper end of its band."""
    xs: list[float | None] = []
    ys: list[float | None] = []
    for at, part_shape in zip(x, parts, strict=True):
        if part_shape.expected_um is not None and part_shape.band_um is not None:
            xs += [at, at, None]
            ys += [
                (part_shape.expected_um - part_shape.band_um) * scale,
                (part_shape.expected_um + part_shape.band_um) * scale,
                None,
            ]
    return [style.lines(xs, ys, style.STEEL, 9)] if xs else []


def _limits(
    series: CharacteristicSeriesShape, x: Sequence[float], ends: tuple[float, float], scale: float
) -> list[Trace]:
    """Limits within the picture."""
    found = []
    for limit in (series.lower_limit_mm, series.upper_limit_mm):
        um = None if limit is None else (limit - series.nominal_mm) * 1000.0
        if um is not None and ends[0] < um < ends[1]:
            found.append(style.lines([0.4, x[-1] + 0.6], [um * scale] * 2, LIMIT, 1.2, line={"dash": "dash"}))
    return found


def _tool_set(x: Sequence[float], parts: Sequence[PartShape], ends: tuple[float, float]) -> list[Trace]:
    """A dotted line before a part for which the tool was set."""
    return [
        style.lines([at - 0.5, at - 0.5], list(ends), style.INK, 1.5, line={"dash": "dot"})
        for at, part_shape in zip(x, parts, strict=True)
        if part_shape.tool_set
    ]


def _marks(x: Sequence[float], parts: Sequence[PartShape], say: Texts) -> list[Trace]:
    scale = say.per_um
    pairs = list(zip(x, parts, strict=True))
    other = [(at, part_shape) for at, part_shape in pairs if part_shape.correction_um != 0.0]
    traces = []
    if other:
        before = [part_shape.before_um * scale for _, part_shape in other]
        traces.append(
            style.dots([at for at, _ in other], before, [""] * len(other), color=BEFORE, symbol="circle-open", size=6)
        )
    says = [_hover(part, say) for part in parts]
    after = [part.after_um * scale for part in parts]
    traces.append(style.dots(list(x), after, says, color=AFTER, size=6))
    alarms = [(at, part_shape) for at, part_shape in pairs if part_shape.alarm]
    if alarms:
        where, height = [at for at, _ in alarms], [part_shape.after_um * scale for _, part_shape in alarms]
        words = [_hover(part_shape, say) for _, part_shape in alarms]
        traces.append(style.dots(where, height, words, color=ALARM, symbol="triangle-up", size=12))
    return traces


def _hover(part: PartShape, say: Texts) -> str:
    band = "" if part.band_um is None or part.expected_um is None else say(
        "<br>expected {expected} ± {band} {um}", expected=say.error(part.expected_um), band=say.size(part.band_um)
    )  # fmt: skip
    return say(
        "part {serial}: {error} {um}", serial=style.label(part.serial), error=say.error(part.after_um)
    ) + band  # fmt: skip


def _weights(x: Sequence[float], parts: Sequence[PartShape], say: Texts) -> list[Trace]:
    values = [part.weight for part in parts]
    line = style.lines(list(x), list(values), style.SOFT, 1.2, yaxis="y2")
    dots = style.dots(list(x), values, [""] * len(values), color=style.INK, size=4)
    return [line, dots | {"yaxis": "y2"}]


LARGEST: Final = 300_000
"""Bytes of figures on one page: what is beyond stands in the table alone."""
MOVED: Final = 0.1
"""A weight that moves by more is said."""
SAID: Final = 3


def series_page(series: SeriesShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    figures, left_out = _figures(series, say)
    note = say("{n} more characteristics stand in the table alone.", n=left_out) if left_out else ""
    body = (
        f'<header><p class="kicker">{say("trueloop · series of parts")}</p><h1>{esc(series.part_type)}</h1>'
        f'<p class="meta">{_kind(series, say)}</p>{_verdict(series, say)}{_how_to_read(series, say)}</header>'
        + section("characteristics", say("Characteristics"), _table(series, say))
        + section(
            "parts",
            say("From part to part"),
            on_screen(say),
            f'<div class="figures pairs">{figures}</div>',
            _note(note),
        )
        + _findings(series, say)
    )
    return html_page(f"{esc(series.part_type)} – {say('series')}", body, language=say.language)


def _note(text: str) -> str:
    return f"<p class='note'>{text}</p>" if text else ""


def _kind(series: SeriesShape, say: Texts) -> str:
    n, parts = len(series.characteristics), series.parts
    if series.kind == "status":
        return say("{parts} parts, {n} characteristics, as they were made.", parts=parts, n=n)
    if series.kind == "simulation":
        return say("{parts} simulated parts, {n} characteristics.", parts=parts, n=n)
    return say("{parts} parts, {n} characteristics, replayed: what memory would have left of them.", parts=parts, n=n)


def _verdict(series: SeriesShape, say: Texts) -> str:
    alarms = [characteristic for characteristic in series.characteristics if characteristic.open_alarm is not None]
    if alarms:
        words = say(
            "Alarm: {names}. Proposals of these wait until the cause is found.",
            names=esc(", ".join(f"{alarm.characteristic} ({alarm.open_alarm})" for alarm in alarms)),
        )
    elif series.kind == "status":
        words = say(
            "No alarm. {n} of {all} characteristics propose a change for the next part.",
            n=sum(characteristic.next is not None for characteristic in series.characteristics),
            all=len(series.characteristics),
        )
    else:
        words = _replayed(series, say)
    return f'<p class="verdict">{words}</p>'


def _replayed(series: SeriesShape, say: Texts) -> str:
    """How many characteristics memory leaves less of, against what was measured and the best other rule."""
    known = [characteristic.left_rms_um for characteristic in series.characteristics if characteristic.left_rms_um]
    return say(
        "Memory would have left less than was measured on {better} of {all} characteristics, and less than every "
        "simpler rule on {best}.",
        better=sum(one["memory"] < one["measured"] for one in known),
        all=len(known),
        best=sum(one["memory"] <= min(one.values()) for one in known),
    )


def _how_to_read(series: SeriesShape, say: Texts) -> str:
    signs = say(
        "Errors are actual less nominal size; a diameter errs by twice the radial error. ● with correction, ○ without, "
        "grey bars: what was expected of ● from the parts before alone (95 %). ▲ alarm; dotted: the tool was set; "
        "dashed: limits. Below: the weight, the share of what a part showed unexpectedly that the next correction acts "
        "on."
    )
    replayed = say("Replayed as if all of a correction arrived; the first part has nothing to go by and is in no mean.")
    return _note(signs) + (_note(replayed) if series.kind == "replay" else "")


def _table(series: SeriesShape, say: Texts) -> str:
    return _status_table(series, say) if series.kind == "status" else _replay_table(series, say)


def _status_table(series: SeriesShape, say: Texts) -> str:
    head = (
        say("characteristic"), say("parts"), say("last ({um})"), say("level ({um})"), say("weight"),
        say("drift ({um})"), say("next change<br>({um})"), say("expected then<br>({um})"),
        say("probability<br>of being in"), "Ppk", say("alarms"),
    )  # fmt: skip
    rows = [_status_row(characteristic, say) for characteristic in series.characteristics]
    note = say(
        "Level: the error had nothing been corrected, ± 95 %. Change: to be added to the size of the next part. Ppk: "
        "with its lower limit of 95 %, from twenty parts on."
    )
    return table(head, rows, words=(0, 10), name="series", stacks=True) + _note(note)


def _status_row(series: CharacteristicSeriesShape, say: Texts) -> list[str]:
    last, ahead, found = series.parts[-1], series.next, series.capability
    name = esc(series.characteristic) + ("" if series.latest else f"<br>{say('earlier nominal or limits')}")
    shares = None if ahead is None else (ahead.probability_before, ahead.probability_after)
    return [
        name,
        str(len(series.parts)),
        say.error(last.after_um),
        "" if series.level_um is None else f"{say.error(series.level_um)} ± {say.size(series.level_band_um or 0.0)}",
        say.number(last.weight, 2),
        "" if last.drift_um is None else say.size(last.drift_um, 2),
        "" if ahead is None else say.error(ahead.size_change_um),
        "" if ahead is None else f"{say.error(ahead.expected_um)} ± {say.size(ahead.band_um)}",
        "" if shares is None or None in shares else " → ".join(f"{say.number(100 * (s or 0.0))} %" for s in shares),
        "" if found is None else f"{say.number(found.ppk, 2)} (≥ {say.number(found.lower, 2)})",
        esc(", ".join(part.serial for part in series.parts if part.alarm)),
    ]


def _replay_table(series: SeriesShape, say: Texts) -> str:
    rules = {
        "measured": say("as measured"),
        "memory": say("memory"),
        "mean of all parts before": say("mean of all<br>parts before"),
        "0.75 of the part before": say("0.75 of the<br>part before"),
    }
    head = (say("characteristic"), say("parts"), *rules.values(), say("bands held"), say("alarms"))
    rows = [
        [
            esc(characteristic.characteristic),
            str(len(characteristic.parts)),
            *(_least(characteristic, rule, say) for rule in rules),
            _held(characteristic.parts[1:]),
            esc(", ".join(part.serial for part in characteristic.parts if part.alarm)),
        ]
        for characteristic in series.characteristics
    ]
    note = say("Root mean square of the errors from the second part on, in {um}; the least is bold.")
    return table(head, rows, words=(0, 7), name="series", stacks=True) + _note(note)


def _least(series: CharacteristicSeriesShape, rule: str, say: Texts) -> str:
    if rule not in series.left_rms_um:
        return ""
    value = series.left_rms_um[rule]
    text = say.size(value, 2)
    return f"<b>{text}</b>" if value == min(series.left_rms_um.values()) else text


def _held(parts: Sequence[PartShape]) -> str:
    return f"{sum(bool(part.inside) for part in parts)} / {len(parts)}"


def _figures(series: SeriesShape, say: Texts) -> tuple[str, int]:
    """Figures of all characteristics as far as the page has room, and how many it has none for."""
    blocks = (
        figure_block(f"series-{k}", series_figure(shape, say), _caption(shape, say), small=True)
        for k, shape in enumerate(series.characteristics, 1)
    )
    return as_room_allows(blocks, len(series.characteristics), LARGEST)


def _caption(series: CharacteristicSeriesShape, say: Texts) -> str:
    more = ""
    if len(series.parts) > SHOWN:
        more = say(", the latest {shown} of {all} parts", shown=SHOWN, all=len(series.parts))
    limits = [f"{say.mm(limit, 4)}" for limit in (series.lower_limit_mm, series.upper_limit_mm) if limit is not None]
    between = f" ({' … '.join(limits)})" if limits else ""
    moves = "".join(f"<br>{move}" for move in list(_moves(series.parts, say))[-SAID:])
    return f"<b>{esc(series.characteristic)}</b>, {say.mm(series.nominal_mm, 4)}{between} {say.mm_name}{more}{moves}"


def _moves(parts: Sequence[PartShape], say: Texts) -> Iterator[str]:
    """Where the weight moved, and why."""
    for before, after in pairwise(parts):
        if abs(after.weight - before.weight) > MOVED:
            reason = after.reason
            yield say(
                "weight {before} → {after} at part {serial}: {reason}",
                before=say.number(before.weight, 2),
                after=say.number(after.weight, 2),
                serial=esc(after.serial),
                reason=esc(say.note(reason) if isinstance(reason, Wording) else reason),
            )


def _findings(series: SeriesShape, say: Texts) -> str:
    if not series.findings:
        return ""
    said = items(f"{esc(finding.code)}: {esc(finding.message)} – {esc(finding.hint)}" for finding in series.findings)
    return section("findings", say("Findings"), said)
