"""Memory of arrays that are done with is kept for the next ones, where the C library lets it be said (glibc).

By itself glibc hands every block from 128 kB on back to the system at once and gets it anew, page by page, for the next
array: of a run with 28 801 samples that was up to half of the time. Here blocks below BLOCK come from what is kept, and
of that up to KEPT stays with the process when nothing needs it. What the environment says of malloc comes first.
Source: mallopt(3), M_MMAP_THRESHOLD and M_TRIM_THRESHOLD.
"""

from __future__ import annotations

import os
import sys
from functools import cache

BLOCK, KEPT = 32 << 20, 128 << 20
"""Bytes; BLOCK is the most that glibc takes."""
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""As mallopt numbers them."""
SAID = ("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_", "GLIBC_TUNABLES")


@cache
def keep_freed_memory() -> bool:
    """Once for a process; whether it is kept now."""
    if not sys.platform.startswith("linux") or any(name in os.environ for name in SAID):
        return False
    import ctypes

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):  # another C library
        return False
    return bool(mallopt(MMAP_THRESHOLD, BLOCK) and mallopt(TRIM_THRESHOLD, KEPT))
