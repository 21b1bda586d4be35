"""The answer by tool: which tool gets which offset, what that moves, and what the contour would take out beyond it.

A shop changes an offset before it changes a program. The offset o moves every feature that its tool cuts by n·o along
the normal, measured or not. Its share of the correction's size is 1 − rms(c − n·o)/rms(c), with c = −w × error curve
evenly along the features that were touched: 1 where the offset is all of it, 0 where as much remains without it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.compensation.limits import cut_mm
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.wording import Um, listed, wording

MOST: Final = 0.5
"""An offset that takes out at least this share of the correction's size does most of the work."""
FELT_MM: Final = 0.0005
"""A move of a feature, or a correction of it, that is larger has a direction worth comparing."""


@dataclass(frozen=True)
class MovedFeature:
    """A feature that the tool cuts, and what the offset does to it, mm along the outward normal: + leaves more on.

    `low_mm` and `high_mm`: the least and the most that it is moved by; `own_mm`: the contour's own correction where the
    two differ most, `moved_mm` the offset's there. `touched`: it was measured; else `own_mm` is an estimate.
    """

    feature: str
    low_mm: float
    high_mm: float
    own_mm: float
    moved_mm: float
    touched: bool

    @property
    def against(self) -> bool:
        """Returns whether the offset moves a measured feature the other way than its own correction would."""
        felt = min(abs(self.own_mm), abs(self.moved_mm)) > FELT_MM
        return self.touched and felt and self.own_mm * self.moved_mm < 0

    @property
    def words(self) -> str:
        """Describes the feature, `face-1 +4.0 µm`, with remarks."""
        low, high = Um(self.low_mm, "+.1f"), Um(self.high_mm, "+.1f")
        if str(low) == str(high):
            moved = wording("{feature} {moved}", feature=self.feature, moved=high)
        else:
            moved = wording("{feature} {low} to {high}", feature=self.feature, low=low, high=high)
        if not self.touched:
            return wording("{moved} (not measured)", moved=moved)
        if self.against:
            own = Um(self.own_mm, "+.1f")
            return wording("{moved} (its own correction would be {own}, the other way)", moved=moved, own=own)
        return moved


@dataclass(frozen=True)
class ToolAnswer:
    """The answer for one tool of the program, by the number of its offset: an offset, none, or not measured."""

    tool: int
    answer: Literal["offset", "none", "not measured"]


@dataclass(frozen=True)
class ByTool:
    """The answers for all tools. `features` are those that the corrected tool cuts, moved by `offset`.

    `share` of the correction's size that the offset takes out; `beyond_mm` is the most that the contour would take out
    beyond it (signed as a correction), at (x, z) `at_mm`, x a radius, on `beyond_on`. `comes_first`: the offset makes
    the correction, or would do most of it.
    """

    offset: WearOffset
    tools: tuple[ToolAnswer, ...]
    features: tuple[MovedFeature, ...]
    share: float
    beyond_mm: float
    beyond_on: str
    at_mm: tuple[float, float]
    comes_first: bool

    @property
    def words(self) -> str:
        """Describes the answers: `T3 wear X −0.024 mm (diameter), Z +0.004; T5 none`."""
        return listed([self._one(tool) for tool in self.tools])

    def _one(self, tool: ToolAnswer) -> str:
        if tool.answer == "none":
            return wording("T{tool} none", tool=tool.tool)
        if tool.answer == "not measured":
            return wording("T{tool} not measured", tool=tool.tool)
        return self.offset.answer

    @property
    def beyond_words(self) -> str:
        """Describes what share of the correction the offset is, and the most that the contour would add."""
        x, z = self.at_mm
        return wording(
            "The offset takes out {share} % of the correction; beyond it the contour would take out up to {beyond}, on "
            "{feature} at x {x:.3f} mm (radius), z {z:.3f} mm.",
            share=round(100 * max(self.share, 0.0)),
            beyond=Um(abs(self.beyond_mm)),
            feature=self.beyond_on,
            x=x,
            z=z,
        )

    @property
    def moved_words(self) -> str:
        """Describes the effect of the offset on every feature that its tool cuts."""
        features = listed([feature.words for feature in self.features])
        return wording(
            "An offset of {who} moves all that it cuts (− takes more off): {features}.",
            who=self.offset.called,
            features=features,
        )


def answer_by_tool(
    profile: Profile,
    model: ProfileErrorModel,
    decision: Decision,
    weight: float,
    commanded: Sequence[CentrePiece],
    offset: WearOffset,
    cut_by: Sequence[int],
    others: Sequence[int],
    in_force: Callable[[int, Array], Array] | None = None,
    wear_mm: tuple[float, float] = (0.0, 0.0),
) -> ByTool:
    """Returns the answer of one correction.

    `commanded` says what the nose cuts of each feature, `cut_by` by the number of which offset, `others` are the
    further numbers that the program runs with. Where `cut_by` holds several numbers no tool gets an offset. `in_force`
    gives what was in force along a feature, (n,), and `wear_mm` (x as a radius, z) what of an offset is in the
    control's wear table: all is counted from there.
    """
    entered = np.array(wear_mm)
    offset_mm, vectors = np.array(decision.whole_offset_mm) - entered, model.vectors
    of_readings = {index for observation in vectors.seen for index in observation.feature_index.tolist()}
    touched = {*vectors.feature_index.tolist(), *of_readings}
    features, own, left, places = [], [], [], []
    for index, (feature, curve, piece) in enumerate(zip(profile.features, model.curves, commanded, strict=True)):
        s = cut_mm(piece)
        normal = feature.outward_normal(s)
        before = np.zeros(len(s)) if in_force is None else in_force(index, s) - normal @ entered
        asked, moved = before - weight * curve.value_mm(s), normal @ offset_mm
        k = int(np.argmax(np.abs(asked - moved)))
        low, high, measured = float(np.min(moved)), float(np.max(moved)), index in touched
        features.append(
            MovedFeature(
                feature=feature.name,
                low_mm=low,
                high_mm=high,
                own_mm=float(asked[k]),
                moved_mm=float(moved[k]),
                touched=measured,
            )
        )
        if measured:
            share_of_length = np.sqrt(max(float(s[-1] - s[0]), 1e-9))
            own.append(rms(asked) * share_of_length)
            left.append(rms(asked - moved) * share_of_length)
            places.append((index, float(s[k]), float(asked[k] - moved[k])))
    whole, rest = float(np.hypot.reduce(own)), float(np.hypot.reduce(left))
    share = 1.0 - rest / whole if whole > 0 else 0.0
    index, s_worst, beyond_mm = max(places, key=lambda place: abs(place[2]))
    x, z = profile.features[index].point_mm(s_worst)
    one = len(set(cut_by)) == 1
    return ByTool(
        offset=offset,
        tools=_answers(offset.tool if one else None, cut_by, others),
        features=tuple(features),
        share=share,
        beyond_mm=beyond_mm,
        beyond_on=profile.features[index].name,
        at_mm=(float(x), float(z)),
        comes_first=one and (decision.by_offset or share >= MOST),
    )


def _answers(corrected: int | None, cut_by: Sequence[int], others: Sequence[int]) -> tuple[ToolAnswer, ...]:
    answers: Mapping[int, Literal["offset", "none", "not measured"]] = {
        **dict.fromkeys(others, "not measured"),
        **({} if corrected is not None else dict.fromkeys(cut_by, "none")),
        **({} if corrected is None else {corrected: "offset"}),
    }
    return tuple(
        ToolAnswer(tool, answers[tool]) for tool in sorted(answers, key=lambda tool: (tool != corrected, tool))
    )
