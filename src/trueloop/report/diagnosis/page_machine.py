"""The page of a machine's model: which axis errors it has wrong, as sets, and what a refined model would leave."""

from collections.abc import Sequence

from trueloop.report.diagnosis.causes import CREDIBLE, SETS, SURE, findings_section
from trueloop.report.diagnosis.figures import bar
from trueloop.report.diagnosis.machine_figures import left_out_figure, residual_figures, signal_of
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape, RefinementShape, TermSetShape
from trueloop.report.diagnosis.names import escaped, share
from trueloop.report.markup import esc, items, section, table
from trueloop.report.shell import figure_block, html_page, on_screen
from trueloop.report.texts.texts import ENGLISH, Texts


def machine_page(found: MachineDiagnosisShape, say: Texts = ENGLISH) -> str:
    """The page as HTML in one file."""
    counted = say(
        "model {model}, {points} gauging points of {parts} parts",
        model=esc(found.model), points=found.points, parts=found.parts,
    )  # fmt: skip
    body = (
        f'<header><p class="kicker">{say("trueloop · diagnosis of a machine’s model")}</p><h1>{esc(found.machine)}</h1>'
        f'<p class="meta">{counted}</p>{_verdict(found, say)}</header>'
        + _sets(found, say)
        + _residuals(found, say)
        + _refinement(found.refinement, say)
        + _own_way(found, say)
        + findings_section(found.findings, say)
    )
    return html_page(f"{esc(found.machine)} – {say('diagnosis')}", body, language=say.language)


def credible_sets(sets: Sequence[TermSetShape]) -> list[TermSetShape]:
    """The fewest sets that together have the probability `CREDIBLE`, likeliest first."""
    found: list[TermSetShape] = []
    for one in sorted(sets, key=lambda each: -each.probability):
        found.append(one)
        if sum(each.probability for each in found) >= CREDIBLE:
            break
    return found


def _verdict(found: MachineDiagnosisShape, say: Texts) -> str:
    likely = [one for one in credible_sets(found.sets) if one.errors]
    if not found.sets:
        words = say("Nothing is concluded; the findings say why.")
    elif found.sound >= SURE or not likely:
        words = say(
            "<strong>Sound</strong>: the model has nothing wrong that {parts} parts could show. Probability {share}.",
            parts=found.parts,
            share=share(found.sound, say),
        )
    elif len(likely) == 1 and len(likely[0].errors) == 1 and found.sound < 1 - SURE:
        words = say(
            "<strong>The model has {error} wrong.</strong> Probability {share}.",
            error=esc(likely[0].errors[0]),
            share=share(likely[0].probability, say),
        )
    else:
        words = say(
            "<strong>The model has one of these wrong</strong>, which these data do not tell apart: {errors}. "
            "Probability that nothing is wrong: {share}.",
            errors=esc(", ".join(dict.fromkeys(name for one in likely for name in one.errors))),
            share=share(found.sound, say),
        )
    return f'<p class="verdict">{words}</p>'


def _sets(found: MachineDiagnosisShape, say: Texts) -> str:
    if not found.sets:
        return ""
    head = (say("axis errors"), say("probability"), "", say("what would tell them apart"))
    rows = [_set_row(one, say) for one in found.sets[:SETS]]
    by_error = [
        (esc(name), share(probability, say), bar(probability, share(probability)))
        for name, probability in list(found.by_error.items())[:SETS]
    ]
    note = say(
        "Errors in one row cannot be told apart with these parts: the probability is that the wrong one is among them. "
        "Their signs and names are those of ISO 230-1."
    )
    each = table((say("axis error"), say("probability that it is wrong"), ""), by_error, words=(0, 2))
    return section(
        "sets",
        say("What the model has wrong"),
        table(head, rows, words=(0, 2, 3), name="sets-table"),
        f"<p class='note'>{note}</p>",
        f"<h3>{say('Each error by itself')}</h3>{each}" if by_error else "",
    )


def _set_row(one: TermSetShape, say: Texts) -> tuple[str, ...]:
    said = share(one.probability, say)
    separated = items(escaped(one.separated_by, say)) if one.separated_by else "–"
    return (
        "<br>".join(map(esc, one.errors)) or say("nothing is wrong"),
        said,
        bar(one.probability, said, sound=not one.errors),
        separated,
    )


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
    changed = say(
        "Version {version} of {parent}, from {parts} parts; updated: {errors}.",
        version=esc(one.version), parent=esc(one.parent), parts=one.parts_used, errors=esc(", ".join(one.errors)),
    )  # fmt: skip
    head = (say("left out"), say("points"), say("before ({um})"), say("after ({um})"), say("change ({um})"))
    rows = [
        (
            esc(left.name),
            str(left.points),
            say.size(left.before_um, 2),
            say.size(left.after_um, 2),
            say.error(left.after_um - left.before_um, 2)
            + ("" if left.standard_u_um is None else f" ± {say.size(left.standard_u_um, 2)}"),
        )
        for left in one.left_out
    ]
    drawn = figure_block("refinement-figure", left_out_figure(one, say), say("○ before, ● after"), True) if rows else ""
    note = say(
        "Root mean square of ERROR_MTG,RESID on parts that the refined model has not seen; ± standard uncertainty."
    )
    return section(
        "refinement",
        say("Refined model"),
        f"<p><strong>{state}</strong> {judged} {changed}</p><p>{esc(say.note(one.reason))}</p>",
        table(head, rows, stacks=True) + f"<p class='note'>{note}</p><div class='figures pairs'>{drawn}</div>"
        if rows
        else "",
    )


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
