"""Labels, made up, each with its text put together by hand."""

from hypothesis import strategies as st

from trueloop.domain.labels import Operation, PartLabel, ProgramLabel
from trueloop.domain.life import Stage

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
DIGITS = "0123456789"
numbers = st.builds(
    lambda a, b, c: a + b + c,
    st.text(LETTERS, max_size=3),
    st.sampled_from(DIGITS),
    st.text(LETTERS + DIGITS, max_size=4),
)
materials = st.builds(lambda a, b: a + b, st.sampled_from(LETTERS), st.text(LETTERS + DIGITS, max_size=4))
patterns = st.text(DIGITS, min_size=1, max_size=3).map(lambda digits: f"P{digits}")
copies = st.text(DIGITS, max_size=4)
part_labels = st.builds(PartLabel, numbers, materials, patterns, copies)
types_of_part = st.builds(PartLabel, numbers, materials, patterns)
program_labels = st.one_of(
    st.builds(
        ProgramLabel, types_of_part, st.sampled_from(Stage), st.sampled_from([Operation.MACHINING, Operation.SCANNING])
    ),
    st.builds(ProgramLabel, types_of_part, st.sampled_from(Stage), st.just(Operation.PROBING), st.sampled_from("XYZ")),
)
