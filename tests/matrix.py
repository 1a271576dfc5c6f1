"""`make test-matrix`: the tests with the lowest versions that pyproject.toml declares and with the newest there are.

Each environment is a venv of its own under .venv/matrix, made from the package index; one that is there is used again.
`python tests/matrix.py 3.11-lowest tests/test_units.py` runs one environment and some tests only.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
PYTHONS = ("3.11", "3.12", "3.13")
LOWEST, NEWEST = "lowest", "newest"
NOT_NEEDED = ("ruff", "mypy", "types-PyYAML", "types-networkx")
"""What `make test` looks at the source with: one version of it is enough."""


def environments() -> list[tuple[str, str]]:
    """Lowest versions with the lowest Python, which alone is older than all of them; the newest with every Python."""
    return [(PYTHONS[0], LOWEST), *((python, NEWEST) for python in PYTHONS)]


def requirements(which: str) -> list[str]:
    """What is declared to run and to be tested: as it is, or each at its lower bound."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    needed = [text for text in declared if re.split("[><=]", text)[0] not in NOT_NEEDED]
    return [text.replace(">=", "==") for text in needed] if which == LOWEST else needed


def find_python(python: str) -> str | None:
    """One on the path that runs – a shim of pyenv for a version that is not chosen does not – or one of pyenv's."""
    known = sorted((Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions").glob(f"{python}.*"))
    for one in (shutil.which(f"python{python}"), *(str(each / "bin" / "python") for each in known[::-1])):
        if (
            one
            and Path(one).exists()
            and subprocess.run([one, "--version"], capture_output=True, check=False).returncode == 0
        ):
            return one
    return None


def prepare(python: str, which: str) -> Path:
    """The interpreter of an environment that has all that is required."""
    where = ROOT / ".venv" / "matrix" / f"{python}-{which}"
    own, marker = where / "bin" / "python", where / "ready"
    wanted = "\n".join(requirements(which))
    if not marker.is_file() or marker.read_text(encoding="utf-8") != wanted:
        found = find_python(python)
        if found is None:
            raise FileNotFoundError(f"there is no python{python}; install it, it is one of {', '.join(PYTHONS)}")
        subprocess.run([found, "-m", "venv", "--clear", str(where)], check=True)
        pip = [str(own), "-m", "pip", "install", "-q", "--disable-pip-version-check", "--only-binary", ":all:"]
        subprocess.run([*pip, *requirements(which)], check=True)
        marker.write_text(wanted, encoding="utf-8")
    return own


def main(names: list[str]) -> int:
    """How many environments failed, told in a line each."""
    known = {f"{python}-{which}": (python, which) for python, which in environments()}
    chosen, rest = [name for name in names if name in known] or [*known], [n for n in names if n not in known]
    failed = []
    for name in chosen:
        try:
            own = prepare(*known[name])
            code = subprocess.run([str(own), "-m", "pytest", "-q", "-n", "2", *rest], cwd=ROOT, check=False).returncode
        except (FileNotFoundError, subprocess.CalledProcessError) as error:
            print(error, file=sys.stderr)
            code = 1
        print(f"{name}: {'failed' if code else 'passed'}", flush=True)
        failed += [name] if code else []
    return len(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
