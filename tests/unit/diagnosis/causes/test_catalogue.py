"""The catalogue of causes is complete, and its page is current."""

import pytest

from scripts.cause_page import PAGE, page
from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.features.feature_error import ErrorKind


def test_the_page_of_causes_is_the_catalogue() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python -m scripts.cause_page`"


def test_every_feature_error_has_a_cause() -> None:
    assert {sign.kind for cause in CAUSES for sign in cause.signs} == set(ErrorKind)


def test_keys_are_unlike_and_every_cause_says_what_to_do() -> None:
    assert len({cause.key for cause in CAUSES}) == len(CAUSES)
    assert all(cause.remedy and cause.decided_by and cause.section for cause in CAUSES)


def test_priors_are_shares() -> None:
    assert all(cause.prior >= 0 for cause in CAUSES)
    assert [cause.key for cause in CAUSES if cause.prior == 0] == ["servo-lag"]


@pytest.mark.parametrize("kind", [ErrorKind.EDGE])
def test_no_touch_sees_edges(kind: ErrorKind) -> None:
    assert all(not sign.seen_by for cause in CAUSES for sign in cause.signs if sign.kind is kind)
