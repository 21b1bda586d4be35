"""Cpk of what was made today: by hand, of the latest parts alone, and none where there are too few."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise
from statistics import fmean

import pytest

from tests.support.factory import PLAN, Shop
from tests.support.series import reading
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.factory.shown import parts
from trueloop.factory.shown.orders import today
from trueloop.factory.views.orders import Cpk
from trueloop.storage.store import Store, keep

SHAFT = PartType("shaft", "B")
ERRORS = [3.0, -2.0, 4.0, 1.0, 0.0, 5.0, -1.0, 2.0] * 3
HALF_ZONE_UM = 30.0
D2 = 1.128379


def by_hand(errors: Sequence[float]) -> float:
    """The nearer limit's distance in three short-term standard deviations, from the mean moving range."""
    sigma = fmean(abs(a - b) for a, b in pairwise(errors)) / D2
    return (HALF_ZONE_UM - abs(fmean(errors))) / (3 * sigma)


def of_part(serial: str, error_um: float, half_zone_um: float = HALF_ZONE_UM, file: str = "") -> Inspection:
    values = (reading("seat", error_um, half_zone_um=half_zone_um),)
    return Inspection(Part(SHAFT, serial), "readings", file or f"file {serial}", 1, values)


@pytest.fixture
def shop(store: Store) -> Shop:
    """A shaft was finished today."""
    made = Shop(store).set_up(replace(PLAN, serials=("a",)))
    made.run()
    made.correct(made.run())
    made.run()
    return made


def cpk_of(shop: Shop) -> tuple[Cpk, ...]:
    return today(shop.store, shop.now).made.cpk


def test_it_is_that_of_the_moving_range_with_its_count(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", one) for k, one in enumerate(ERRORS)])
    (found,) = cpk_of(shop)
    assert (found.part_type, found.characteristic, found.count) == ("shaft", "seat", 24)
    assert found.cpk == pytest.approx(by_hand(ERRORS), rel=1e-5)
    assert found.low and found.cpk and found.high and found.low < found.cpk < found.high


def test_too_few_parts_say_so(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", one) for k, one in enumerate(ERRORS[:19])])
    assert cpk_of(shop) == (Cpk("shaft", "seat", None, None, None, 19, 20),)
    keep(shop.store, [of_part("last", 1.0)])
    (found,) = cpk_of(shop)
    assert found.count == 20
    assert found.cpk == pytest.approx(by_hand([*ERRORS[:19], 1.0]), rel=1e-5)


def test_equal_values_and_values_without_limits_have_none(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", 2.0) for k in range(20)])
    assert cpk_of(shop) == (Cpk("shaft", "seat", None, None, None, 20, 20),)


def test_a_part_counts_once_and_not_as_it_was_before_the_finish_cut(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", one) for k, one in enumerate(ERRORS)])
    keep(shop.store, [of_part("23", 7.0, file="measured again")])
    early, cut = of_part("x", 400.0, file="semi-finished"), Cut(Part(SHAFT, "x"), Stage.SEMIFINISH)
    keep(shop.store, [early, cut, InspectionLink(early.identity, cut.identity)])
    (found,) = cpk_of(shop)
    assert found.count == 24
    assert found.cpk == pytest.approx(by_hand([*ERRORS[:-1], 7.0]), rel=1e-5)


def test_other_limits_begin_another_series(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", one) for k, one in enumerate(ERRORS)])
    keep(shop.store, [of_part("new", 1.0, half_zone_um=10.0)])
    assert cpk_of(shop) == (Cpk("shaft", "seat", None, None, None, 1, 20),)


def test_only_the_latest_parts_are_read_and_nothing_is_computed_twice(
    shop: Shop, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parts, "LATEST", 24)
    keep(shop.store, [of_part(f"old {k}", 20.0 + k) for k in range(30)])
    keep(shop.store, [of_part(f"{k}", one + 0.125) for k, one in enumerate(ERRORS)])
    parts._cpk.cache_clear()
    before = parts._cpk.cache_info()
    (found,) = cpk_of(shop)
    assert found.count == 24
    assert found.cpk == pytest.approx(by_hand([one + 0.125 for one in ERRORS]), rel=1e-5)
    assert cpk_of(shop) == (found,)
    after = parts._cpk.cache_info()
    assert (after.misses - before.misses, after.hits - before.hits) == (1, 1)


def test_another_day_has_none(shop: Shop) -> None:
    keep(shop.store, [of_part(f"{k}", one) for k, one in enumerate(ERRORS)])
    assert today(shop.store, shop.now + timedelta(days=2)).made.cpk == ()
