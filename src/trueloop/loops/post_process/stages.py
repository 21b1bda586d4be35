"""The five stages of automation [4773 §3], and what each may change in the post-process loop [4773 §5]."""

from collections.abc import Mapping
from enum import IntEnum, StrEnum
from typing import Final

from trueloop.domain.proposal import ProposalClass


class Parameter(StrEnum):
    """The five classes of parameters that may be adjusted [4773 §2]."""

    TOOL_OFFSET = "tool offset"
    NC_CODE = "NC code"
    REAL_TIME = "real-time compensation values"
    MODEL = "parameters of a model"
    WEIGHT = "weighting factors"


class Stage(IntEnum):
    """The stages, in the order in which a shop takes them up; the fifth goes along with all others [4773 §3.5]."""

    OFFSETS = 1  # tool offsets are adjusted
    PATHS = 2  # real-time compensation values or NC code are revised
    IDENTIFICATION = 3  # the error term that needs adjustment is named; a person adjusts it
    MODEL = 4  # the parameters of the model are adjusted
    WEIGHTS = 5  # the factors of stages 1, 2 and 4 are adjusted


ADJUSTS: Final[Mapping[Stage, frozenset[Parameter]]] = {
    Stage.OFFSETS: frozenset({Parameter.TOOL_OFFSET}),
    Stage.PATHS: frozenset({Parameter.NC_CODE, Parameter.REAL_TIME}),
    Stage.IDENTIFICATION: frozenset(),
    Stage.MODEL: frozenset({Parameter.MODEL}),
    Stage.WEIGHTS: frozenset({Parameter.WEIGHT}),
}
"""What each stage automates, whichever loop it runs in."""

NOT_AFTER_THE_PROCESS: Final = frozenset({Parameter.NC_CODE, Parameter.REAL_TIME})
"""These "cannot be performed in the post-process loop" [4773 §5 (2)], against its §3.3, where they could."""

CLASSES: Final[Mapping[Parameter, ProposalClass]] = {
    Parameter.TOOL_OFFSET: ProposalClass.TOOL_OFFSET,
    Parameter.MODEL: ProposalClass.MEMORY,  # what is remembered is this loop's model
    Parameter.WEIGHT: ProposalClass.WEIGHT,
}
"""The class of the proposals that change a parameter."""


def may_change(stage: Stage) -> frozenset[ProposalClass]:
    """What a stage may change in the post-process loop: nothing at all in stages 2 and 3."""
    return frozenset(CLASSES[one] for one in ADJUSTS[stage] - NOT_AFTER_THE_PROCESS)


def stage_of(changes: ProposalClass) -> Stage:
    """The stage that a proposal belongs to."""
    return next(stage for stage in Stage if changes in may_change(stage))
