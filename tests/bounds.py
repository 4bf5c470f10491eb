"""A bound on processor time that tells seconds from minutes, on a slow and busy machine too."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

#: Many times what any of the bounded work takes. What it guards against takes minutes, or for ever: how fast work is
#: is shown by the bench, never by a test.
SECONDS = 20.0


@contextmanager
def bounded_time() -> Iterator[None]:
    """Fail if the body takes more than `SECONDS` of this process's time."""
    start = time.process_time()
    yield
    assert time.process_time() - start < SECONDS
