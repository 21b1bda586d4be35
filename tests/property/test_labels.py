"""Labels come back as they were written, also out of file names; what is no label is refused at its wrong place."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.labels import copies, materials, numbers, part_labels, patterns, program_labels
from trueloop.domain.labels import Label, PartLabel, contradictions, labels_in, names_part, read_label
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError

WHOLE = re.compile(
    r"[A-Z]*[0-9][A-Z0-9]*-[A-Z][A-Z0-9]*-P[0-9]+(\.[0-9]+|-[RSF]-([MS]|D-[XYZ]))?|[0-9]{4}\.[0-9]{3}|[0-9]{6}"
)
"""The grammar once more, as one expression: the reader takes it field by field."""


@given(part_labels | program_labels)
def test_a_label_comes_back_as_it_was_written(label: Label) -> None:
    assert read_label(str(label)) == label
    assert read_label(str(label).lower()) == label


@given(numbers, materials, patterns, copies)
def test_a_label_holds_what_its_text_says(number: str, material: str, pattern: str, copy: str) -> None:
    read = read_label(f"{number}-{material}-{pattern}" + (f".{copy}" if copy else ""))
    assert read == PartLabel(number, material, pattern, copy)


@given(
    part_labels | program_labels,
    st.sampled_from(["", "inspection of ", "x_", "run-", "Ä"]),
    st.sampled_from(["", ".csv", ".nc", " (2).dmo", "_b.txt", "-old.csv"]),
)
def test_a_file_name_gives_the_label_that_it_contains(label: Label, before: str, after: str) -> None:
    assert labels_in(f"{before}{label}{after}") == (label,)


@given(st.text("0123456789AP-.RSFMDX", max_size=18) | st.text(max_size=12))
def test_a_text_is_a_label_or_is_refused_where_no_label_goes_on(text: str) -> None:
    if WHOLE.fullmatch(text.upper()) and text.isascii():
        assert str(read_label(text)) == text.upper()
        return
    with pytest.raises(TrueloopError) as refused:
        read_label(text)
    character = refused.value.values["character"]
    assert refused.value.code is Code.LAB_FORM
    assert isinstance(character, int) and 1 <= character <= len(text) + 1


@given(part_labels)
def test_the_label_of_a_part_agrees_with_it_and_with_no_other_copy(label: PartLabel) -> None:
    part = Part(PartType(label.number.lower(), material=label.material), label.copy)
    assert names_part(label, part)
    assert not contradictions(label, part.part_type, part.serial)
    if label.copy:
        assert not names_part(label, Part(part.part_type, f"{label.copy}1"))
        assert contradictions(label, part.part_type, f"{label.copy}1")
