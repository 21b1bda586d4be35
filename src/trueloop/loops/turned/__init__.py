"""The loops of a turned part: process-intermittent and post-process."""
