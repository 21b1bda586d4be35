"""Error curves of a whole profile: bad touches, junctions, uncertainty and its budget."""
