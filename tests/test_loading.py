"""Loading a machine is quick, so that a command answers at once."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from network.machine.machine import Machine

LARGEST = max((Path(__file__).parents[1] / "machines").glob("*.yaml"), key=lambda path: path.stat().st_size)


def test_loading_brings_in_no_heavy_library() -> None:
    code = f"import sys; from network import Machine; Machine.load({str(LARGEST)!r}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"networkx", "scipy.optimize", "scipy.sparse", "scipy.integrate", "matplotlib", "rich"}
    assert not heavy & set(done.stdout.split())


@pytest.mark.speed
def test_a_machine_loads_within_thirty_milliseconds() -> None:
    def seconds() -> float:
        start = time.process_time()
        Machine.load(LARGEST)
        return time.process_time() - start

    assert min(seconds() for _ in range(5)) < 0.03
