"""Settings of the whole suite: hypothesis draws the same examples at every run and keeps no data base; Ctrl-C is heard."""

import signal

from hypothesis import settings

settings.register_profile("deterministic", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("deterministic")

# A shell starts what it puts in the background deaf to Ctrl-C, and child processes are born as deaf: tests press it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
