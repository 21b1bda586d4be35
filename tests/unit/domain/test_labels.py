"""Labels of [6811 §4.3]: NIST's own forms, the places of mistakes, and labels beside what they are linked with."""

import csv
from pathlib import Path

import pytest

from trueloop.domain.labels import (
    NistPart,
    NistProgram,
    Operation,
    PartLabel,
    ProgramLabel,
    contradictions,
    labels_in,
    names_part,
    read_label,
)
from trueloop.domain.life import Stage
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError

FACETST = PartType("1411", material="A2")


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("1411-A2-P1.560", PartLabel("1411", "A2", "P1", "560")),
        ("1411-A2-P1", PartLabel("1411", "A2", "P1")),
        ("1411-A2-P1.007", PartLabel("1411", "A2", "P1", "007")),
        ("1411-A2-P1-S-D-X", ProgramLabel(PartLabel("1411", "A2", "P1"), Stage.SEMIFINISH, Operation.PROBING, "X")),
        ("1411-A2-P1-F-M", ProgramLabel(PartLabel("1411", "A2", "P1"), Stage.FINISH, Operation.MACHINING)),
        ("1411-A2-P1-R-S", ProgramLabel(PartLabel("1411", "A2", "P1"), Stage.ROUGH, Operation.SCANNING)),
        ("1411.559", NistPart("1411", "559")),
        ("060011", NistProgram("060011")),
    ],
)
def test_what_a_label_says(text: str, label: object) -> None:
    assert read_label(text) == label
    assert str(label) == text


@pytest.mark.parametrize(
    ("text", "character"),
    [
        ("", 1),
        ("shaft-A2-P1", 1),  # no digit
        ("1411", 5),
        ("1411_A2_P1", 1),
        ("1411-22-P1", 6),
        ("1411-A2", 8),
        ("1411-A2-X1", 9),
        ("1411-A2-P", 9),
        ("1411-A2-P1.", 12),
        ("1411-A2-P1.56b", 12),
        ("1411-A2-P1.560-S-M", 15),  # a program is the same for all copies
        ("1411-A2-P1-T-M", 12),
        ("1411-A2-P1-S", 13),
        ("1411-A2-P1-S-D", 15),  # probing has a direction
        ("1411-A2-P1-S-D-W", 16),
        ("1411-A2-P1-S-M-X", 15),  # machining has none
        ("1411.55", 5),
        ("\uff11411-A2-P1", 1),  # a digit, but none of ASCII
    ],
)
def test_what_is_no_label_is_refused_at_the_character(text: str, character: int) -> None:
    with pytest.raises(TrueloopError) as refused:
        read_label(text)
    assert (refused.value.code, refused.value.values["character"]) == (Code.LAB_FORM, character)


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("1411-A2-P1.560.csv", ["1411-A2-P1.560"]),
        ("1411-A2-P1.nc", ["1411-A2-P1"]),
        ("1411-A2-P1.3mf", ["1411-A2-P1"]),
        ("2026-11-23.csv", []),
        ("shaft-b-p1.csv", []),
        ("060011.nc", ["060011"]),
        ("1411.559 and 1411.560.txt", ["1411.559", "1411.560"]),
        ("1060011.nc", []),
        ("12.1411.559", []),
    ],
)
def test_labels_in_file_names(name: str, found: list[str]) -> None:
    assert [str(label) for label in labels_in(name)] == found


def test_nists_parts_are_read_and_their_stages_are_not_computed() -> None:
    """[6811] Tables 8–11: the finish inspection has the semi-finish one's number plus 1 eight times, plus 2 twice."""
    file = Path(__file__).parents[3] / "src/trueloop/examples/nist/nistir-6811-errors.csv"
    rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    labels = {f"{row['part']}.{row['inspection']}" for row in rows}
    assert all(str(read_label(label)) == label for label in labels)
    numbers = {
        (row["part"], row["stage"]): int(row["inspection"]) for row in rows if row["family"] in ("MODBAS2", "PIECS11")
    }
    steps = [numbers[part, "finish"] - number for (part, stage), number in numbers.items() if stage == "semifinish"]
    assert sorted(steps) == [1] * 8 + [2] * 2


def test_a_label_that_agrees_with_its_link_finds_nothing() -> None:
    label = read_label("1411-A2-P1.560")
    assert not contradictions(label, FACETST, "560")
    assert not contradictions(label, PartType("steps", drawing="1411", material="aluminium 6061-T6"), "560")
    assert not contradictions(label, PartType("steps"), ""), "what is not stated contradicts nothing"
    assert not contradictions(read_label("1411-A2-P1-S-D-X"), FACETST, "560", Stage.SEMIFINISH)
    assert not contradictions(read_label("2811.559"), FACETST, "560", Stage.FINISH), "an alias states no fact"


@pytest.mark.parametrize(
    ("label", "part_type", "serial", "stage", "in_label", "in_link"),
    [
        ("1411-A2-P1.560", FACETST, "561", None, "560", "561"),
        ("1411-A2-P1.560", PartType("1511", material="A2"), "560", None, "1411", "1511"),
        ("1411-A2-P1.560", PartType("1411", material="C45"), "560", None, "A2", "C45"),
        ("1411-A2-P1-S-M", FACETST, "560", Stage.FINISH, "semifinish", "finish"),
        ("1411-A2-P1-S-M", PartType("1511"), "560", Stage.SEMIFINISH, "1411", "1511"),
    ],
)
def test_a_label_that_contradicts_its_link(
    label: str, part_type: PartType, serial: str, stage: Stage | None, in_label: str, in_link: str
) -> None:
    found = contradictions(read_label(label), part_type, serial, stage)
    assert [(one.code, one.values["in_label"], one.values["in_link"]) for one in found] == [
        (Code.LAB_LINK, in_label, in_link)
    ]


def test_which_parts_a_label_means() -> None:
    part = Part(FACETST, "560")
    assert names_part(read_label("1411-A2-P1.560"), part)
    assert names_part(read_label("1411-A2-P7"), part), "the type, of any copy"
    assert not names_part(read_label("1411-A2-P1.561"), part)
    assert not names_part(read_label("1411-A2-P1.560"), Part(PartType("shaft"), "560"))
    assert not names_part(read_label("1411-A2-P1-S-M"), part), "a program is no part"


def test_which_parts_nists_alias_means() -> None:
    alias = read_label("2511.139")
    assert names_part(alias, Part(PartType("MODBAS2"), "2511"))
    assert names_part(alias, Part(PartType("MODBAS2"), "2511.139"))
    assert names_part(alias, Part(PartType("2511"), "139"))
    assert not names_part(alias, Part(PartType("2511"), "140"))
    assert not names_part(alias, Part(PartType("MODBAS2"), "2512"))


@pytest.mark.parametrize(
    "fields",
    [
        ("14-11", "A2", "P1"),
        ("1411", "A2-P1", "P1"),
        ("1411", "a2", "P1"),
        ("1411", "A2", "P1", "5.6"),
        ("", "A", "P1"),
    ],
)
def test_a_label_that_would_read_back_otherwise_cannot_be_made(fields: tuple[str, ...]) -> None:
    with pytest.raises(TrueloopError, match="LAB-FORM"):
        PartLabel(*fields)


def test_a_program_label_with_a_copy_or_a_wrong_direction_cannot_be_made() -> None:
    kind, copy = PartLabel("1411", "A2", "P1"), PartLabel("1411", "A2", "P1", "560")
    for part, operation, direction in (
        (copy, Operation.MACHINING, ""),
        (kind, Operation.PROBING, ""),
        (kind, Operation.PROBING, "x"),
        (kind, Operation.MACHINING, "X"),
    ):
        with pytest.raises(TrueloopError, match="LAB-FORM"):
            ProgramLabel(part, Stage.FINISH, operation, direction)
