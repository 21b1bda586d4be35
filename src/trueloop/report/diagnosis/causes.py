"""Causes on a page: the verdict in a sentence, a card for each cause, sets, and what would decide."""

from collections.abc import Sequence
from typing import Final

from trueloop.report.diagnosis.figures import COVERAGE, bar
from trueloop.report.diagnosis.shapes import (
    CandidateShape,
    CausesShape,
    FeatureErrorShape,
    FeatureMeansShape,
    HypothesisShape,
    MeanShape,
    UnexplainedShape,
)
from trueloop.report.markup import esc, items, section, table
from trueloop.report.series.values import FindingShape
from trueloop.report.texts.texts import ENGLISH, Texts

SEEN: float = 0.0005
"""A probability nearer to 0 or 1 is said to be below or above."""


def kind_name(kind: str, say: Texts = ENGLISH) -> str:
    """Returns a kind of error in the reader's language."""
    known = {
        "radius": say("radius"),
        "length": say("length"),
        "taper of a shaft": say("taper of a shaft"),
        "taper of a face": say("taper of a face"),
        "edge": say("edge"),
        "straightness": say("straightness"),
        "waviness": say("waviness"),
        "eccentricity": say("eccentricity"),
        "lobing": say("three lobes"),
    }
    return known.get(kind, kind)


def device_name(device: str, say: Texts = ENGLISH) -> str:
    """Returns the name of the device that saw an error."""
    return {"machine": say("machine’s probe"), "CMM": say("CMM or gauge")}.get(device, device)


def error_name(error: FeatureErrorShape | FeatureMeansShape | UnexplainedShape, say: Texts = ENGLISH) -> str:
    """Names the feature of an error, or both of a length, as plain text."""
    return f"{error.feature} − {error.other}" if error.other else error.feature


def share(probability: float, say: Texts = ENGLISH) -> str:
    """Formats a probability in percent; what is all but 0 or 1 as below or above."""
    if probability < SEEN:
        return f"< {say.number(100 * SEEN, 2)} %"
    if probability > 1 - SEEN:
        return f"> {say.number(100 * (1 - SEEN), 2)} %"
    return f"{say.number(100 * probability)} %"


def with_u(value_um: float | None, u_um: float | None, say: Texts = ENGLISH, *, signed: bool = True) -> str:
    """Formats a value ± its standard uncertainty; a dash where it is not known."""
    if value_um is None:
        return "–"
    text = say.error(value_um) if signed else say.size(value_um)
    return text if u_um is None else f"{text} ± {say.size(u_um)}"


def mean_with_u(mean: MeanShape | None, say: Texts = ENGLISH) -> str:
    """Formats a mean ± its standard uncertainty."""
    return "–" if mean is None else with_u(mean.mean_um, mean.standard_u_um, say)


def escaped(words: Sequence[str], say: Texts) -> list[str]:
    """Sentences of the diagnosis in the reader's language, harmless."""
    return [esc(say.note(word)) for word in words]


SURE: Final = 0.9
"""From this probability on one answer is said alone."""
CREDIBLE: Final = 0.95
"""Sets are said until together they have this probability."""
LEAST: Final = 0.01
"""Causes below it have no card."""
CARDS: Final = 12
SETS: Final = 8
TOLD: Final = 4
"""Errors, or sets of causes, that the verdict names."""
UNEXPLAINED: Final = 20
"""Rows of what is not explained."""


def verdict(causes: CausesShape | None, parts: int, say: Texts, unexplained: Sequence[UnexplainedShape] = ()) -> str:
    """Returns one sentence: sound as clearly as guilty, and no single name where the data leave several."""
    if causes is None:
        words = say("Nothing is concluded; the findings say why.")
    elif causes.sound >= 0.5 and unexplained:
        words = say(
            "<strong>No known cause</strong> ({share} that none acts), but errors beyond their uncertainty: {errors}.",
            share=share(causes.sound, say),
            errors=_unexplained_names(unexplained, say),
        )
    elif causes.sound >= SURE:
        words = say(
            "<strong>Sound</strong>: nothing acts that {parts} parts could show. Probability {share}.",
            parts=parts,
            share=share(causes.sound, say),
        )
    elif causes.sound >= 0.5:
        words = say(
            "<strong>Probably sound</strong> ({share}); most probable otherwise: {causes}.",
            share=share(causes.sound, say),
            causes=_named([hypothesis for hypothesis in causes.hypotheses if hypothesis.causes][:1], causes, say),
        )
    else:
        words = _guilty_verdict(causes, say)
    return f'<p class="verdict">{words}</p>'


def _unexplained_names(unexplained: Sequence[UnexplainedShape], say: Texts) -> str:
    told = [f"{esc(error_name(shape))}, {kind_name(shape.kind, say)}" for shape in unexplained]
    names = list(dict.fromkeys(told))
    more = [say("{n} more", n=len(names) - TOLD)] if len(names) > TOLD else []
    return "; ".join([*names[:TOLD], *more])


def unexplained_section(unexplained: Sequence[UnexplainedShape], say: Texts) -> str:
    """Errors beyond their uncertainty that no probable cause acts on."""
    if not unexplained:
        return ""
    shows = {"mean": say("mean"), "scatter": say("parts differ")}
    rows = [
        (
            esc(error_name(shape)),
            kind_name(shape.kind, say),
            device_name(shape.device, say),
            shows[shape.shows],
            say.error(shape.size_um) if shape.shows == "mean" else say.size(shape.size_um),
            say.size(shape.standard_u_um),
        )
        for shape in unexplained[:UNEXPLAINED]
    ]
    note = say(
        "The causes of the catalogue that may act on these have less than 50 % together. Standard uncertainty: of the "
        "mean, or of one part where the parts differ."
    )
    head = (say("feature"), say("error"), say("seen by"), say("shows"), say("size ({um})"), say("uncertainty ({um})"))
    left_out = len(unexplained) - len(rows)
    more = " " + say("{n} more stand in the JSON.", n=left_out) if left_out else ""
    return section(
        "unexplained",
        say("Not explained"),
        table(head, rows, words=(0, 1, 2, 3), stacks=True),
        f"<p class='note'>{note}{more}</p>",
    )


def _guilty_verdict(causes: CausesShape, say: Texts) -> str:
    likely = credible(causes.hypotheses)
    found = [shape for shape in likely if shape.causes]
    if found and found[0].probability >= SURE:
        return say(
            "<strong>Cause found</strong>: {causes}. Probability {share}.",
            causes=_named(found[:1], causes, say),
            share=share(found[0].probability, say),
        )
    return say(
        "<strong>One of {n} answers</strong>, which these data do not tell apart: {causes}. Probability that nothing "
        "acts: {share}.",
        n=len(found),
        causes=_named(found, causes, say),
        share=share(causes.sound, say),
    )


def credible(hypotheses: Sequence[HypothesisShape]) -> list[HypothesisShape]:
    """Returns the fewest that together have the probability `CREDIBLE`, likeliest first."""
    found: list[HypothesisShape] = []
    for hypothesis in sorted(hypotheses, key=lambda each: -each.probability):
        found.append(hypothesis)
        if sum(each.probability for each in found) >= CREDIBLE:
            break
    return found


def _named(sets: Sequence[HypothesisShape], causes: CausesShape, say: Texts) -> str:
    """Sets by the names of their causes; of many the likeliest."""
    told = [together(shape.causes, causes, say) for shape in sets[:TOLD]]
    more = [say("{n} more", n=len(sets) - TOLD)] if len(sets) > TOLD else []
    return "; ".join([*told, *more]) or "–"


def together(keys: Sequence[str], causes: CausesShape, say: Texts) -> str:
    """Causes that act together, by name."""
    names = {candidate.key: candidate.name for candidate in causes.candidates}
    return " + ".join(esc(say.note(names.get(key, key))) for key in keys) or say("nothing acts")


def causes_section(causes: CausesShape | None, say: Texts) -> str:
    """Cards of the causes, the sets with their probabilities, and what would decide."""
    if causes is None:
        return ""
    shown = [candidate for candidate in causes.candidates if candidate.probability >= LEAST][:CARDS]
    left_out = len(causes.candidates) - len(shown)
    rest = say(
        "{n} more causes were weighed: each has less than {share}.", n=left_out, share=_below(causes, shown, say)
    )
    return (
        section(
            "causes",
            say("Causes"),
            _sound(causes, say),
            *(_card(shape, say) for shape in shown),
            f"<p class='note'>{rest}</p>" if left_out else "",
        )
        + (section("decide", say("What would decide"), items(escaped(causes.decide, say))) if causes.decide else "")
        + section("sets", say("What acts together"), _sets(causes, say))
    )


def _below(causes: CausesShape, shown: Sequence[CandidateShape], say: Texts) -> str:
    """Returns the bound of the most probable cause without a card."""
    likeliest = max((candidate.probability for candidate in causes.candidates if candidate not in shown), default=0.0)
    return share(max(LEAST, likeliest), say)


def _sound(causes: CausesShape, say: Texts) -> str:
    said = share(causes.sound, say)
    return (
        f'<div class="cause"><h3>{say("nothing acts")}<span>{said}</span></h3>'
        f"{bar(causes.sound, said, sound=True)}</div>"
    )


def _card(one: CandidateShape, say: Texts) -> str:
    said = share(one.probability, say)
    rows = [
        (say("tool"), esc(one.tool)),
        (say("on"), esc(", ".join(one.features)) or "–"),
        (say("size, if it acts"), _size(one, say)),
        (say("for it"), _marked("for", one.supports, say)),
        (say("against it"), _marked("against", one.contradicts, say)),
        (say("remedy"), f"{esc(say.note(one.remedy))} <span class='note'>{esc(source(one.section))}</span>"),
        (say("decided by"), esc(say.note(one.decided_by))),
    ]
    listed = "".join(f"<dt>{name}</dt><dd>{text}</dd>" for name, text in rows if text)
    return (
        f'<div class="cause"><h3>{esc(say.note(one.name))}<span>{said}</span></h3>{bar(one.probability, said)}'
        f"<dl>{listed}</dl></div>"
    )


def source(section: str) -> str:
    """Cites a section of [4773]; what is not a number is returned as it stands."""
    return f"[4773 §{section}]" if section[:1].isdigit() else section


def _size(candidate: CandidateShape, say: Texts) -> str:
    if candidate.size_um is None:
        return ""
    u = "" if candidate.standard_u_um is None else f" ± {say.size(COVERAGE * candidate.standard_u_um)}"
    return f"{say.error(candidate.size_um)}{u} {say.um} (95 %)" if u else f"{say.error(candidate.size_um)} {say.um}"


def _marked(kind: str, words: Sequence[str], say: Texts) -> str:
    return f"<ul>{''.join(f'<li class={kind}>{text}</li>' for text in escaped(words, say))}</ul>" if words else ""


def _sets(causes: CausesShape, say: Texts) -> str:
    rows = [
        (
            together(hypothesis.causes, causes, say),
            share(hypothesis.probability, say),
            bar(hypothesis.probability, share(hypothesis.probability)),
        )
        for hypothesis in causes.hypotheses[:SETS]
    ]
    return table((say("causes"), say("probability"), ""), rows, words=(0, 2))


def findings_section(findings: Sequence[FindingShape], say: Texts) -> str:
    """Writes the section of what is odd, with what to do."""
    if not findings:
        return ""
    said = items(f"{esc(finding.code)}: {esc(say.note(finding.message))} – {esc(finding.hint)}" for finding in findings)
    return section("findings", say("Findings"), said)
