"""The page of a machine's model: which axis errors it has wrong, as sets, and what a refined model would leave."""

from typing import Final

from trueloop.report.diagnosis.causes import SETS, SURE, findings_section
from trueloop.report.diagnosis.figures import bar
from trueloop.report.diagnosis.machine_figures import left_out_figure, left_out_name, residual_figures, signal_of
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape, RefinementShape, TermSetShape
from trueloop.report.diagnosis.names import escaped, share
from trueloop.report.markup import esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.style import plain, signed
from trueloop.report.texts.texts import ENGLISH, Texts

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


def _verdict(found: MachineDiagnosisShape, say: Texts) -> str:
    """Sound as clearly as guilty, and never one name out of a set."""
    if not found.residuals:
        words = say("Nothing is concluded; the findings say why.")
    elif not found.sets and found.sound >= SURE:
        words = say(
            "<strong>Sound</strong>: the model has nothing wrong that {parts} parts could show. Probability {share}.",
            parts=found.parts,
            share=share(found.sound, say),
        )
    elif not found.sets:
        words = say(
            "<strong>Probably sound</strong>: nothing wrong is likelier than not. Probability {share}.",
            share=share(found.sound, say),
        )
    else:
        named = "; ".join(_one_of(one, say) for one in found.sets)
        words = say(
            "<strong>The model has wrong</strong>: {errors}. Probability that nothing is wrong: {share}.",
            errors=named,
            share=share(found.sound, say),
        )
    return f'<p class="verdict">{words}</p>'


def _frames(found: MachineDiagnosisShape, say: Texts) -> str:
    """How the part frames of both devices lie to each other."""
    if found.frames is None:
        return ""
    return section(
        "frames", say("Part frames of machine and measuring machine"), f"<p>{escaped([found.frames], say)[0]}</p>"
    )


def _one_of(one: TermSetShape, say: Texts) -> str:
    """The only name of a set, or all of them."""
    names = [esc(each.error) for each in one.errors]
    if len(names) == 1:
        return names[0]
    if one.at_least > 1:
        return say(
            "at least {n} of {names}, which these data do not tell apart", n=one.at_least, names=", ".join(names)
        )
    return say("one of {names}, which these data do not tell apart", names=", ".join(names))


def _sets(found: MachineDiagnosisShape, say: Texts) -> str:
    by_error = [
        (esc(name), share(probability, say), bar(probability, share(probability)))
        for name, probability in list(found.by_error.items())[:SETS]
    ]
    if not found.sets and not by_error:
        return ""
    note = say(
        "Errors of one set cannot be told apart with these parts: its probability is that the wrong one is among them. "
        "Names and signs are those of ISO 230-1. Single points scatter by {scatter} {um}.",
        scatter=say.size(found.scatter_um),
    )
    each = table((say("axis error"), say("probability that it is wrong"), ""), by_error, words=(0, 2))
    return section(
        "sets",
        say("What the model has wrong"),
        *(_card(one, say) for one in found.sets),
        f"<p class='note'>{note}</p>",
        f"<h3>{say('Each error by itself')}</h3>{each}" if by_error else "",
    )


def _card(one: TermSetShape, say: Texts) -> str:
    said = share(one.probability, say)
    names = " · ".join(esc(each.error) for each in one.errors)
    listed = "".join(
        f"<li>{esc(each.error)} {_follows(each.follows, say)}: {share(each.probability, say)}</li>"
        for each in one.errors
    )
    rows = [(say("each"), f"<ul>{listed}</ul>")]
    if one.separated_by:
        rows.append((say("told apart by"), items(escaped(one.separated_by, say))))
    return (
        f'<div class="cause"><h3>{names}<span>{said}</span></h3>{bar(one.probability, said)}'
        f"<dl>{''.join(f'<dt>{name}</dt><dd>{text}</dd>' for name, text in rows)}</dl></div>"
    )


def _follows(signal: str, say: Texts) -> str:
    return say("with {signal}", signal=esc(signal)) if signal else say("at all times")


def _residuals(found: MachineDiagnosisShape, say: Texts) -> str:
    if not found.residuals:
        return ""
    blocks = "".join(
        figure_block(f"residuals-{k + 1}", figure, f"<b>{esc(name)}</b>", small=True)
        for k, (name, figure) in enumerate(residual_figures(found, say).items())
    )
    note = say(
        "ERROR_MTG,RESID at every gauging point, along the outward normal, + where material is left on. Over a "
        "position: less the mean of its part, because every part may be set up elsewhere; blue the colder half, red "
        "the warmer half of the points by {signal}. Over a temperature: as found. Lines: means of neighbours.",
        signal=esc(signal_of(found) or "–"),
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


def _changes(one: RefinementShape, say: Texts) -> str:
    """Returns the table of the largest changes (HTML)."""
    if not one.changes:
        return ""
    largest = sorted(one.changes, key=lambda each: -abs(each.new - each.old))[:CHANGES]
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


def _own_way(found: MachineDiagnosisShape, say: Texts) -> str:
    if not found.own_way:
        return ""
    rows = [
        (str(k + 1), esc(one.error), esc(one.signal), say.number(one.correlation, 2))
        for k, one in enumerate(found.own_way)
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
