"""The page of a series: what each characteristic does from part to part, before and after correction."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from trueloop.report.markup import as_room_allows, esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.series.figure import SHOWN, series_figure
from trueloop.report.series.values import CharacteristicSeriesShape, PartShape, SeriesShape
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.wording import Wording

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
