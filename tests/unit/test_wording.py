"""A wording is its English text, and keeps what it is made of."""

import pickle

from trueloop.wording import Signed, Um, all_of, shell_word, wording


def test_the_text_is_that_of_template_and_values() -> None:
    said = wording("{feature}: {left} left, p = {p:.2g}", feature="dome {x}", left=Um(-0.0443, "+.1f"), p=1.6e-23)
    assert said == "dome {x}: −44.3 µm left, p = 1.6e-23"
    assert (said.template, said.values["feature"]) == ("{feature}: {left} left, p = {p:.2g}", "dome {x}")


def test_names_are_joined() -> None:
    assert all_of(["dome"]) == "dome"
    assert all_of(["neck", "dome", "tip"]) == "neck and dome and tip"


def test_numbers_have_a_true_minus() -> None:
    assert (str(Signed(-0.024, 3)), str(Signed(0.004, 3))) == ("−0.024", "+0.004")


def test_it_comes_back_from_pickle_with_its_parts() -> None:
    said = wording("{n} touches", n=3)
    again = pickle.loads(pickle.dumps(said))
    assert (again, again.template, again.values) == (said, said.template, said.values)


def test_a_word_of_a_command_is_quoted_as_the_shell_of_the_system_takes_it() -> None:
    """cmd.exe has no single quotes, and a backslash needs none there."""
    assert [shell_word(word) for word in ("shaft/job.toml", "my shaft")] == ["shaft/job.toml", "'my shaft'"]
    on_windows = [shell_word(word, windows=True) for word in ("shaft\\job.toml", "my shaft")]
    assert on_windows == ["shaft\\job.toml", '"my shaft"']
