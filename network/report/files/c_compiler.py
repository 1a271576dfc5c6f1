"""The C compiler of this machine, where there is one."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic")


def find_compiler() -> str | None:
    return shutil.which("gcc") or shutil.which("cc")


def compile_c(source: Path, to: Path, more: Sequence[str] = ()) -> bool:
    """Whether a file could be built, its warnings errors; False without a compiler, too."""
    compiler = find_compiler()
    if compiler is None:
        return False
    words = [compiler, *FLAGS, *more, str(source), "-o", str(to)]
    return subprocess.run(words, capture_output=True, check=False).returncode == 0
