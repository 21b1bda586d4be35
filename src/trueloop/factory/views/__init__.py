"""The shapes of the service's answers to people and cells, filled from the store.

Times are ISO 8601 with zone; lengths are mm, errors µm, positive where material is left on. A field that is None is not
known, and is shown so.
"""
