"""Closed-loop machining: measure the part, model the error, cut the next pass true."""


def __getattr__(name: str) -> str:
    """`__version__`, looked up when asked for: importing package metadata takes longer than the rest of start-up."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version

    return version("trueloop")
