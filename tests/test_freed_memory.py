"""Memory that is kept: arrays of a run are not fetched from the system page by page again and again."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

FAULTS = """
import numpy as np, resource, sys
from network.platform.freed_memory import keep_freed_memory
kept = keep_freed_memory()
def fill():
    for _ in range(50):
        np.ones(500_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
fill(); before = fill()
print(int(kept), fill() - before)
"""
PAGES = 50 * 4_000_000 // 4096


def count_faults(**environment: str) -> tuple[int, int]:
    """Whether memory is kept, and how often the system gave a page for the same arrays made again."""
    ran = subprocess.run(
        [sys.executable, "-c", FAULTS], env=os.environ | environment, cwd=Path(__file__).parent.parent,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    kept, faults = ran.stdout.split()
    return int(kept), int(faults)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc lets it be said")
def test_arrays_that_are_made_again_take_no_new_pages() -> None:
    kept, faults = count_faults()
    assert kept and faults < PAGES / 100


@pytest.mark.parametrize("name", ["MALLOC_TRIM_THRESHOLD_", "GLIBC_TUNABLES"])
def test_what_the_environment_says_comes_first(name: str) -> None:
    value = "131072" if name.startswith("MALLOC") else "glibc.malloc.arena_max=1"
    assert not count_faults(**{name: value})[0]
