"""The types of all products' corrections, for a store that keeps any of them."""

from functools import cache

from trueloop.domain.codec import Codec
from trueloop.loops.machine import program as machine
from trueloop.loops.surface import correction as surface
from trueloop.loops.turned import provenance as turned


@cache
def store_codec() -> Codec:
    """Makes one codec that reads what those of the products write."""
    types: dict[str, type] = {}
    for codec in (turned.CODEC, surface.CODEC, machine.CODEC):
        for name, kind in codec.types.items():
            if types.setdefault(name, kind) is not kind:
                raise TypeError(f"{name!r} names two types: {types[name]} and {kind}")
    return Codec(types)
