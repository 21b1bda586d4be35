"""What a store holds stays readable: no field of a stored type goes away, and new ones have defaults."""

from tests.support.stored_fields import FILE, fields_of, kept, page
from trueloop.jobs.store.codec import store_codec


def test_stored_documents_stay_readable() -> None:
    """Else they need a migration: a correction is read whole, long after it was made."""
    types = store_codec().types
    for name, before in kept().items():
        assert name in types, f"{name} is stored: migrate its documents"
        today = fields_of(types[name])
        assert not before - set(today), f"{name}: fields that stored documents have are gone: migrate the documents"
        needed = {field for field, is_needed in today.items() if is_needed}
        assert not needed - before, f"{name}: fields that stored documents lack need a default"


def test_the_list_of_fields_is_that_of_today() -> None:
    assert FILE.read_text(encoding="utf-8") == page(), "run  python -m tests.support.stored_fields"
