"""The page of a machine's model: which axis errors it has wrong, as sets, and what a refined model would leave."""

from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.report import style
from trueloop.report.diagnosis.causes import SETS, SURE, escaped, findings_section, share
from trueloop.report.diagnosis.figures import bar
from trueloop.report.diagnosis.machine_shapes import LeftOutShape, MachineDiagnosisShape, RefinementShape, TermSetShape
from trueloop.report.markup import esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.style import Figure, plain, signed
from trueloop.report.texts.texts import ENGLISH, Texts

WIDTH: Final = 480
HEIGHT: Final = 300
POINTS: Final = 800
"""Marks of one figure: more would not be seen."""
BINS: Final = 9
SPEAKS: Final = 200


def residual_figures(diagnosis: MachineDiagnosisShape, say: Texts = ENGLISH) -> dict[str, Figure]:
    """Draws residuals over each axis, less the mean of their part and by colder and warmer halves; over each
    temperature unchanged. By name; what does not vary has none.
    """
    if not diagnosis.residuals:
        return {}
    warm = warmer(diagnosis)
    figures = {}
    for axis in diagnosis.residuals[0].position_mm:
        at = np.array([residual.position_mm.get(axis, np.nan) for residual in diagnosis.residuals]) * say.per_mm
        if np.ptp(at) > 0.0:
            name = say("position of {axis} ({mm})", axis=style.label(axis))
            figures[name] = _scatter(name, at, without_set_up(diagnosis), warm, diagnosis, say)
    for signal, values in diagnosis.temperatures.items():
        at = np.array(values)
        if np.ptp(at) > 0.0:
            name = say("temperature {signal} (°C)", signal=style.label(signal))
            as_found = np.array([residual.residual_um for residual in diagnosis.residuals])
            figures[name] = _scatter(name, at, as_found, None, diagnosis, say)
    return figures


def signal_of(diagnosis: MachineDiagnosisShape) -> str | None:
    """Returns the temperature that the likeliest errors follow, else the one that varies most; None: none varies."""
    varying = {name: float(np.ptp(at)) for name, at in diagnosis.temperatures.items() if at and np.ptp(at) > 0.0}
    named = [error.follows for shape in diagnosis.sets for error in shape.errors if error.follows in varying]
    return named[0] if named else max(varying, key=lambda name: varying[name], default=None)


def warmer(diagnosis: MachineDiagnosisShape) -> NDArray[np.bool_] | None:
    """Returns which points are of the warmer half; None where no temperature varies."""
    signal = signal_of(diagnosis)
    if signal is None:
        return None
    at = np.array(diagnosis.temperatures[signal])
    half: NDArray[np.bool_] = at > np.median(at)
    return half


def without_set_up(diagnosis: MachineDiagnosisShape) -> Array:
    """Residuals less the mean of their part, µm."""
    by_part: dict[str, list[float]] = defaultdict(list)
    for residual in diagnosis.residuals:
        by_part[residual.part].append(residual.residual_um)
    return np.array([residual.residual_um - float(np.mean(by_part[residual.part])) for residual in diagnosis.residuals])


def _scatter(
    name: str, at: Array, values_um: Array, warm: NDArray[np.bool_] | None, diagnosis: MachineDiagnosisShape, say: Texts
) -> Figure:
    values = values_um * say.per_um
    every = np.arange(len(at)) % max(1, -(-len(at) // POINTS)) == 0
    marks, means = [], []
    groups = {style.SOFT: np.ones(len(at), dtype=bool)} if warm is None else {style.TAKEN: ~warm, style.LEFT_ON: warm}
    for colour, rows in groups.items():
        shown = np.flatnonzero(rows & every)
        says = [_hover(diagnosis.residuals[k].part, values_um[k], say) if len(at) <= SPEAKS else "" for k in shown]
        marks.append(
            style.dots(at[shown].tolist(), values[shown].tolist(), says, color=colour, size=3) | {"opacity": 0.5}
        )
        if rows.any():
            middles, levels = binned(at[rows], values[rows])
            means.append(style.lines(list(middles), list(levels), style.INK if warm is None else colour, 3))
    low, high = style.padded(values.tolist(), 0.08, 1.0)
    span = 0.04 * float(np.ptp(at))
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(name, float(at.min()) - span, float(at.max()) + span, 6),
        yaxis=style.axis(say("residual ({um})"), low, high, 6),
        separators=say.separators,
    )
    return {"data": marks + means, "layout": layout}


def _hover(part: str, um: float, say: Texts) -> str:
    return f"{style.label(part)}: {say.error(float(um))} {say.um}"


def binned(at: Array, values: Array) -> tuple[list[float], list[float]]:
    """Means of neighbours: of groups alike in number, none of which parts equal places."""
    places, inverse = np.unique(at, return_inverse=True)
    seen = np.cumsum(np.bincount(inverse)) - np.bincount(inverse)
    group = (seen * min(BINS, len(places)) // len(at))[inverse]
    middles = [float(at[group == g].mean()) for g in np.unique(group)]
    means = [float(values[group == g].mean()) for g in np.unique(group)]
    return middles, means


def left_out_name(one: LeftOutShape, say: Texts = ENGLISH) -> str:
    """Names what was left out."""
    return say("parts, in {n} groups", n=one.groups) if one.of == "parts" else say("part types, {n}", n=one.groups)


def left_out_figure(refinement: RefinementShape, say: Texts = ENGLISH) -> Figure:
    """Draws for parts and part types left out a line from what the model leaves (○) to that of the refined one (●)."""
    row = [float(len(refinement.left_out) - k) for k in range(len(refinement.left_out))]
    before = [left.before_um * say.per_um for left in refinement.left_out]
    after = [left.after_um * say.per_um for left in refinement.left_out]
    colours = [style.AFTER if b <= a else style.OUT for a, b in zip(before, after, strict=True)]
    data = [style.lines([a, b], [y, y], c, 2) for a, b, y, c in zip(before, after, row, colours, strict=True)]
    says = [f"{say.size(left.before_um, 2)} → {say.size(left.after_um, 2)} {say.um}" for left in refinement.left_out]
    data.append(style.dots(list(before), row, [""] * len(row), color=style.SOFT, symbol="circle-open", size=8))
    data.append(style.dots(list(after), row, says, color=colours, size=8))
    layout = style.layout(
        WIDTH,
        30 * len(row) + 80,
        margin={"l": 145, "r": 12, "t": 10, "b": 54},
        xaxis=style.axis(
            say("ERROR_MTG,RESID, root mean square ({um})"), 0.0, 1.08 * max(*before, *after, say.per_um), 5
        ),
        yaxis=style.axis(
            "",
            0.4,
            len(row) + 0.6,
            tickvals=row,
            ticktext=[left_out_name(left, say) for left in refinement.left_out],
            gridcolor=style.PALE_STEEL,
        ),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


CHANGES: Final = 12
"""Rows of what a refined model says otherwise."""


def machine_page(found: MachineDiagnosisShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    counted = say(
        "model {model}, {points} gauging points of {parts} parts",
        model=esc(found.model), points=found.points, parts=found.parts,
    )  # fmt: skip
    body = (
        f'<header><p class="kicker">{say("trueloop · diagnosis of a machine’s model")}</p><h1>{esc(found.machine)}</h1>'
        f'<p class="meta">{counted}</p>{_verdict(found, say)}</header>'
        + _sets(found, say)
        + _residuals(found, say)
        + _frames(found, say)
        + _refinement(found.refinement, say)
        + _own_way(found, say)
        + findings_section(found.findings, say)
    )
    return html_page(f"{esc(found.machine)} – {say('diagnosis')}", body, language=say.language)


def _verdict(diagnosis: MachineDiagnosisShape, say: Texts) -> str:
    """Sound as clearly as guilty, and never one name out of a set."""
    if not diagnosis.residuals:
        words = say("Nothing is concluded; the findings say why.")
    elif not diagnosis.sets and diagnosis.sound >= SURE:
        words = say(
            "<strong>Sound</strong>: the model has nothing wrong that {parts} parts could show. Probability {share}.",
            parts=diagnosis.parts,
            share=share(diagnosis.sound, say),
        )
    elif not diagnosis.sets:
        words = say(
            "<strong>Probably sound</strong>: nothing wrong is likelier than not. Probability {share}.",
            share=share(diagnosis.sound, say),
        )
    else:
        named = "; ".join(_one_of(shape, say) for shape in diagnosis.sets)
        words = say(
            "<strong>The model has wrong</strong>: {errors}. Probability that nothing is wrong: {share}.",
            errors=named,
            share=share(diagnosis.sound, say),
        )
    return f'<p class="verdict">{words}</p>'


def _frames(diagnosis: MachineDiagnosisShape, say: Texts) -> str:
    """How the part frames of both devices lie to each other."""
    if diagnosis.frames is None:
        return ""
    return section(
        "frames", say("Part frames of machine and measuring machine"), f"<p>{escaped([diagnosis.frames], say)[0]}</p>"
    )


def _one_of(terms: TermSetShape, say: Texts) -> str:
    """The only name of a set, or all of them."""
    names = [esc(each.error) for each in terms.errors]
    if len(names) == 1:
        return names[0]
    if terms.at_least > 1:
        return say(
            "at least {n} of {names}, which these data do not tell apart", n=terms.at_least, names=", ".join(names)
        )
    return say("one of {names}, which these data do not tell apart", names=", ".join(names))


def _sets(diagnosis: MachineDiagnosisShape, say: Texts) -> str:
    by_error = [
        (esc(name), share(probability, say), bar(probability, share(probability)))
        for name, probability in list(diagnosis.by_error.items())[:SETS]
    ]
    if not diagnosis.sets and not by_error:
        return ""
    note = say(
        "Errors of one set cannot be told apart with these parts: its probability is that the wrong one is among them. "
        "Names and signs are those of ISO 230-1. Single points scatter by {scatter} {um}.",
        scatter=say.size(diagnosis.scatter_um),
    )
    each = table((say("axis error"), say("probability that it is wrong"), ""), by_error, words=(0, 2))
    return section(
        "sets",
        say("What the model has wrong"),
        *(_card(shape, say) for shape in diagnosis.sets),
        f"<p class='note'>{note}</p>",
        f"<h3>{say('Each error by itself')}</h3>{each}" if by_error else "",
    )


def _card(terms: TermSetShape, say: Texts) -> str:
    said = share(terms.probability, say)
    names = " · ".join(esc(each.error) for each in terms.errors)
    listed = "".join(
        f"<li>{esc(each.error)} {_follows(each.follows, say)}: {share(each.probability, say)}</li>"
        for each in terms.errors
    )
    rows = [(say("each"), f"<ul>{listed}</ul>")]
    if terms.separated_by:
        rows.append((say("told apart by"), items(escaped(terms.separated_by, say))))
    return (
        f'<div class="cause"><h3>{names}<span>{said}</span></h3>{bar(terms.probability, said)}'
        f"<dl>{''.join(f'<dt>{name}</dt><dd>{text}</dd>' for name, text in rows)}</dl></div>"
    )


def _follows(signal: str, say: Texts) -> str:
    return say("with {signal}", signal=esc(signal)) if signal else say("at all times")


def _residuals(diagnosis: MachineDiagnosisShape, say: Texts) -> str:
    if not diagnosis.residuals:
        return ""
    blocks = "".join(
        figure_block(f"residuals-{k + 1}", figure, f"<b>{esc(name)}</b>", small=True)
        for k, (name, figure) in enumerate(residual_figures(diagnosis, say).items())
    )
    note = say(
        "ERROR_MTG,RESID at every gauging point, along the outward normal, + where material is left on. Over a "
        "position: less the mean of its part, because every part may be set up elsewhere; blue the colder half, red "
        "the warmer half of the points by {signal}. Over a temperature: as found. Lines: means of neighbours.",
        signal=esc(signal_of(diagnosis) or "–"),
    )
    return section(
        "residuals",
        say("What the model left"),
        f"<p class='note'>{note}</p>",
        on_screen(say),
        f'<div class="figures pairs">{blocks}</div>',
    )


def _refinement(one: RefinementShape | None, say: Texts) -> str:
    if one is None:
        return ""
    if one.accepted:
        state = say("In force: accepted {accepted}.", accepted=esc(one.accepted))
    else:
        state = say("Offered, not in force: <code>trueloop machine accept</code> puts it in force.")
    judged = say("It leaves less, beyond the uncertainty.") if one.better else say("It does not leave less.")
    changed = say("Version {version}, from {parts} parts.", version=one.version, parts=one.parts)
    head = (say("left out"), say("points"), say("before ({um})"), say("after ({um})"), say("better by ({um})"))
    rows = [
        (
            left_out_name(left, say),
            str(left.points),
            say.size(left.before_um, 2),
            say.size(left.after_um, 2),
            f"{say.error(left.better_um, 2)} ± {say.size(left.standard_u_um, 2)}",
        )
        for left in one.left_out
    ]
    note = say(
        "Root mean square of ERROR_MTG,RESID on parts that the refined model has not seen; ± standard uncertainty."
    )
    figures = (
        figure_block("refinement-figure", left_out_figure(one, say), say("○ before, ● after"), True) if rows else ""
    )
    return section(
        "refinement",
        say("Refined model"),
        f"<p><strong>{state}</strong> {judged} {changed}</p><p>{esc(say.note(one.reason))}</p>",
        table(head, rows, stacks=True) + f"<p class='note'>{note}</p><div class='figures pairs'>{figures}</div>"
        if rows
        else "",
        _changes(one, say),
        f"<p class='note hash'>{say('Refines')} {esc(one.parent)}</p>",
    )


def _changes(refinement: RefinementShape, say: Texts) -> str:
    """Returns the table of the largest changes (HTML)."""
    if not refinement.changes:
        return ""
    largest = sorted(refinement.changes, key=lambda each: -abs(each.new - each.old))[:CHANGES]
    head = (say("axis error"), say("position"), say("temperatures"), say("was"), say("becomes"), say("unit"))
    rows = [
        (
            esc(each.error),
            "–" if each.at is None else say.number(each.at, 1),
            esc(", ".join(f"{name} {say.number(value)}" for name, value in each.signals.items())) or "–",
            say.spelled(signed(each.old)),
            say.spelled(f"{signed(each.new)} ± {plain(each.standard_u)}"),
            each.unit,
        )
        for each in largest
    ]
    return f"<h3>{say('What it says otherwise')}</h3>" + table(head, rows, words=(0, 2, 5), stacks=True)


def _own_way(diagnosis: MachineDiagnosisShape, say: Texts) -> str:
    if not diagnosis.own_way:
        return ""
    rows = [
        (str(k + 1), esc(shape.error), esc(shape.signal), say.number(shape.correlation, 2))
        for k, shape in enumerate(diagnosis.own_way)
    ]
    note = say(
        "For comparison: the largest correlation first, then the largest of what it leaves, and so on [4773 §3.3]. It "
        "names one error at a time, also where the data cannot tell several apart."
    )
    head = (say("step"), say("axis error"), say("temperature"), say("correlation"))
    return section(
        "own-way",
        say("One correlation after another"),
        f"<p class='note'>{note}</p>",
        table(head, rows, words=(0, 1, 2)),
    )
