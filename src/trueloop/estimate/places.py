"""Places of cuts: where an error is, and of which edge, part type, part and cut."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class Places:
    """Columns of n values each, by name: whatever the terms of a catalogue use.

    Those of a turned part are listed in `catalogue`. Labels (edge, part, feature group) are arrays of text or whole
    numbers, all other columns of floating-point numbers.
    """

    columns: Mapping[str, NDArray[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def number(self, name: str) -> Array:
        """Returns a column of numbers, (n,)."""
        return np.asarray(self.columns[name], dtype=np.float64)

    def labels(self, names: Sequence[str]) -> list[tuple[Any, ...]]:
        """Returns the values of some columns, one tuple per place."""
        if not names:
            return [()] * len(self)
        return list(zip(*(self.columns[name].tolist() for name in names), strict=True))

    def chosen(self, rows: ArrayLike) -> "Places":
        """Returns some of the places, by position."""
        at = np.asarray(rows)
        return Places({name: column[at] for name, column in self.columns.items()})

    def altered(self, **values: object) -> "Places":
        """Returns these places with columns set to one value each."""
        columns = {name: np.full(len(self), value) for name, value in values.items()}
        return Places({**self.columns, **columns})


def joined(parts: Sequence[Places]) -> Places:
    """Places one after the other; all with the same columns."""
    return Places({name: np.concatenate([one.columns[name] for one in parts]) for name in parts[0].columns})
