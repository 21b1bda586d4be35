"""Proposals and decisions survive the codec; there is no class for what the post-process loop may not change."""

from datetime import UTC, datetime

import pytest

from trueloop.domain.part import PartType
from trueloop.domain.proposal import Effect, Proposal, ProposalClass, ProposalDecision
from trueloop.domain.values import CODEC
from trueloop.errors import TrueloopError

NOW = datetime(2026, 3, 1, 12, tzinfo=UTC)
EFFECT = Effect("bore", ("COVER", "", "bore"), 4, -0.03, 0.03, 0.0, 0.002, 0.4, 0.99)
PROPOSAL = Proposal("ab12", ProposalClass.TOOL_OFFSET, PartType("COVER"), (EFFECT,), "4", NOW, "me")


def test_a_proposal_and_its_decision_come_back_equal() -> None:
    decision = ProposalDecision("ab12", "accepted", "me", NOW, "looked at it", overrides=("SER-OLD",))
    assert CODEC.from_json(CODEC.to_json(PROPOSAL), Proposal) == PROPOSAL
    assert CODEC.from_json(CODEC.to_json(decision), ProposalDecision) == decision
    assert decision.identity == PROPOSAL.identity


@pytest.mark.parametrize("changes", ["NC program", "real-time values"])
def test_a_document_cannot_propose_what_this_loop_may_not_change(changes: str) -> None:
    with pytest.raises(TrueloopError, match="ProposalClass"):
        CODEC.from_json(CODEC.to_json(PROPOSAL).replace('"tool offset"', f'"{changes}"'), Proposal)
