"""Decisions: pure functions from what is known, what is asked, by whom and when, to `Changes`; or a refusal raised."""
