"""Settings of the whole suite: hypothesis draws the same examples at every run and keeps no data base."""

from hypothesis import settings

settings.register_profile("deterministic", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("deterministic")
