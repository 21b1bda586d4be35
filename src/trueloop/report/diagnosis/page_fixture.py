"""The page of a fixturing: repeats at one point right after fixturing, of part, tool probe and part probe."""

from trueloop.report.diagnosis.causes import findings_section
from trueloop.report.diagnosis.figures import COVERAGE, fixturing_figure
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape, FixturingShape, JudgedShape
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page, on_screen
from trueloop.report.texts.texts import ENGLISH, Texts


def fixture_page(found: FixtureDiagnosisShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    figures = "".join(
        figure_block(f"fixturing-{k + 1}", fixturing_figure(one, say), f"<b>{esc(one.name)}</b>", small=True)
        for k, one in enumerate(found.fixturings)
    )
    how = say(
        "Repeats at one point, each less their mean, with bars of 95 %; dashed: what they may vary by; grey: a drift "
        "or a step beyond chance. While a fixturing is unstable nothing else is concluded [4773 §4.1]."
    )
    drawn = (
        (
            _table(found, say),
            f"<p class='note'>{how}</p>",
            on_screen(say),
            f'<div class="figures pairs">{figures}</div>',
        )
        if found.fixturings
        else (f"<p>{say('No repeats are known.')}</p>",)
    )
    body = (
        f'<header><p class="kicker">{say("trueloop · fixturing")}</p><h1>{esc(found.machine)}</h1>'
        f"{_verdict(found, say)}</header>"
        + section("repeats", say("Repeats"), *drawn)
        + findings_section(found.findings, say)
    )
    return html_page(f"{esc(found.machine)} – {say('fixturing')}", body, language=say.language)


def _verdict(found: FixtureDiagnosisShape, say: Texts) -> str:
    unstable = [one.name for one in found.fixturings if not one.stable]
    if not found.fixturings:
        words = say("Nothing is concluded; the findings say why.")
    elif unstable:
        words = say(
            "<strong>Unstable</strong>: {names}. Nothing else is concluded until this is mended.",
            names=esc(", ".join(unstable)),
        )
    else:
        words = say(
            "<strong>Stable</strong>: {names}. Repeats vary by no more than chance and limits allow.",
            names=esc(", ".join(one.name for one in found.fixturings)),
        )
    return f'<p class="verdict">{words}</p>'


def _table(found: FixtureDiagnosisShape, say: Texts) -> str:
    head = (
        say("fixturing"), say("repeats"), say("spread ({um})"), say("drift ({um})"), say("step ({um})"),
        say("limit ({um})"), say("verdict"),
    )  # fmt: skip
    rows = [
        (
            esc(one.name),
            str(len(one.values_um)),
            _judged(one.spread, say, signed=False),
            _judged(one.drift, say),
            _judged(one.step, say) + _where(one, say),
            "–" if one.limit_um is None else say.size(one.limit_um),
            f"✓ {say('stable')}" if one.stable else f"<strong>✗ {say('unstable')}</strong>",
        )
        for one in found.fixturings
    ]
    note = say("± 95 %; bold: beyond what chance explains.")
    return table(head, rows, words=(0, 6), name="fixturings", stacks=True) + f"<p class='note'>{note}</p>"


def _judged(one: JudgedShape, say: Texts, *, signed: bool = True) -> str:
    value = say.error(one.value_um) if signed else say.size(one.value_um)
    text = f"{value} ± {say.size(COVERAGE * one.standard_u_um)}"
    return f"<strong>{text}</strong>" if one.significant else text


def _where(one: FixturingShape, say: Texts) -> str:
    if one.step_after is None or not one.step.significant:
        return ""
    return "<br>" + say("after repeat {n}", n=one.step_after)
