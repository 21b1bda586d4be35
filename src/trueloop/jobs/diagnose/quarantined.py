"""Parts that are to teach nothing."""

from trueloop.domain.life import Identity, Quarantine
from trueloop.storage.store import Store, find


def quarantined_cuts(store: Store) -> frozenset[Identity]:
    """Cuts in quarantine: of each the latest word counts."""
    words = sorted((one.value for one in find(store, Quarantine)), key=lambda one: one.at)
    latest = {one.cut: one.lifted for one in words}
    return frozenset(cut for cut, lifted in latest.items() if not lifted)


def quarantined_parts(store: Store) -> frozenset[Identity]:
    """Returns the parts of the cuts in quarantine: a cut's identity begins with its part's."""
    return frozenset(cut[:3] for cut in quarantined_cuts(store))
