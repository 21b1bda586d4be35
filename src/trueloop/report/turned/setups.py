"""What the programs of a part's set-ups are corrected by: the answer by set-up and tool, as text, JSON and page."""

import json
from collections.abc import Iterator, Mapping

from trueloop.loops.turned.setup_corrections import CorrectedSetup, CorrectedSetups
from trueloop.report.markup import esc, items, section, table
from trueloop.report.shell import html_page
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.characteristics import characteristics_as_dicts
from trueloop.report.turned.joint import (
    answer_words,
    changes_of,
    joint_as_dict,
    notes_of,
    rows_of_edge,
    sizes_section,
    to_do,
)
from trueloop.report.turned.setups_drawing import drawing
from trueloop.wording import wording


def answers(corrected: CorrectedSetups) -> list[str]:
    """`first: T1 wear X −0.024 mm (diameter), Z +0.004`, one of each set-up."""
    return [
        wording("{setup}: {words}", setup=one.frame.name, words=answer_words(one.joint)) for one in corrected.setups
    ]


def all_to_do(corrected: CorrectedSetups) -> list[str]:
    """What to enter and what to run, by set-up."""
    return [
        wording("{setup}: {words}", setup=one.frame.name, words=to_do(one.joint, one.name)) for one in corrected.setups
    ]


def all_notes(corrected: CorrectedSetups) -> list[str]:
    """What to know of all set-ups together, and of the edges of each."""
    return [
        *corrected.notes,
        *(
            wording("{setup}: {words}", setup=one.frame.name, words=note)
            for one in corrected.setups
            for note in notes_of(one.joint)
        ),
    ]


def setups_as_dict(corrected: CorrectedSetups) -> dict[str, object]:
    """For machines: what to do, and by set-up its frame, its program and its edges."""
    return {
        "part": corrected.part,
        "record_id": corrected.record_id,
        "words": answers(corrected),
        "to_do": all_to_do(corrected),
        "uncut": list(corrected.uncut),
        "notes": all_notes(corrected),
        "characteristics": characteristics_as_dicts(corrected.characteristics),
        "setups": [_setup(one) for one in corrected.setups],
    }


def setups_json(corrected: CorrectedSetups) -> str:
    """Returns the text of `part.json`."""
    return json.dumps(setups_as_dict(corrected), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _setup(one: CorrectedSetup) -> dict[str, object]:
    frame = one.frame
    return {
        "name": frame.name,
        "zero_at_z_mm": frame.zero_at_z_mm,
        "flipped": frame.flipped,
        "mirrored_z": frame.mirrored_z,
        "z_of_program": frame.words,
        "features": list(one.features),
        **{key: value for key, value in joint_as_dict(one.joint, one.name).items() if key != "part"},
    }


def setups_page(corrected: CorrectedSetups, reports: Mapping[tuple[str, str], str], say: Texts = ENGLISH) -> str:
    """The page of a part with several set-ups; `reports`: file name of each edge's own report, by set-up and tool."""
    title = say("{part} – correction {record}", part=esc(corrected.part), record=esc(corrected.record_id))
    notes = all_notes(corrected)
    sizes = [*corrected.characteristics, *(size for one in corrected.setups for size in one.joint.characteristics)]
    verdict = "<br>".join(
        f"<strong>{esc(say.note(answer))}</strong><br>{esc(say.note(run))}"
        for answer, run in zip(answers(corrected), all_to_do(corrected), strict=True)
    )
    body = (
        f"<header><h1>{esc(corrected.part)}</h1></header><p class='verdict'>{verdict}</p>"
        + section("setups", say("Set-ups"), _frames(corrected, say), drawing(corrected))
        + section("edges", say("Errors of the features"), _features(corrected, reports, say))
        + sizes_section(sizes, say)
        + (section("notes", say("Decisions"), items(esc(say.note(note)) for note in notes)) if notes else "")
        + section(
            "program", say("Changes to the program"), *(changes_of(o.joint, o.name, say) for o in corrected.setups)
        )
    )
    return html_page(title, body, language=say.language)


def _frames(corrected: CorrectedSetups, say: Texts) -> str:
    head = (say("set-up"), say("program"), say("its Z by z of the part"), say("features"))
    rows = [
        [
            esc(one.frame.name),
            f"<code>{esc(one.joint.source_name)}</code>",
            esc(one.frame.words),
            esc(", ".join(one.features)),
        ]
        for one in corrected.setups
    ]
    left = [["–", "", "", esc(", ".join(corrected.uncut))]] if corrected.uncut else []
    return table(head, [*rows, *left], words=(0, 1, 2, 3), name="frames", stacks=True)


def _features(corrected: CorrectedSetups, reports: Mapping[tuple[str, str], str], say: Texts) -> str:
    head = (say("set-up"), say("feature"), say("tool"), say("touches"), say("before<br>worst {um}"),
            say("after<br>worst {um}"), say("largest U<br>{um}"), say("correction"))  # fmt: skip
    return table(head, _rows(corrected, reports, say), words=(0, 1, 2, 7), name="by-setup", stacks=True)


def _rows(corrected: CorrectedSetups, reports: Mapping[tuple[str, str], str], say: Texts) -> Iterator[list[str]]:
    for setup in corrected.setups:
        for edge in setup.joint.edges:
            report = reports[setup.frame.name, edge.tool]
            for row in rows_of_edge(edge, report, say):
                yield [esc(setup.frame.name), *row]
