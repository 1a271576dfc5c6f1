"""The turning centre, June against August: what has changed about it between its runs of 2020.

`python -m bench.lathe_then_and_now` from the folder tests/; some minutes.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from network import Machine, find_changes
from network.recordings.load_source import load_recording
from network.recordings.recording import Recording

ROOT = Path(__file__).parents[2]
MAPPING = ROOT / "tests" / "recordings" / "cnc_lathe.yaml"
RUNS = ROOT.parent / "shared" / "recordings" / "cnc-lathe"
NEAREST = 5


def runs_of_month(month: str, folder: Path) -> list[Recording]:
    """All runs of a month, each through the mapping with its own file in it."""
    text = MAPPING.read_text(encoding="utf-8").splitlines()
    read = []
    for path in sorted(RUNS.glob(f"run_{month}*.csv")):
        at = folder / f"{path.stem}.yaml"
        lines = [f"file: {path}" if line.startswith("file:") else line for line in text]
        at.write_text("\n".join(lines) + "\n", encoding="utf-8")
        read.append(load_recording(at))
    return read


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        june, august = (runs_of_month(month, Path(folder)) for month in ("202006", "202008"))
        found = find_changes(Machine.load(ROOT / "machines" / "cnc_lathe.yaml"), august, june)
    print(found)
    nearest = sorted(found.tested.items(), key=lambda item: -abs(item[1]))[:NEAREST]
    print("\nNearest to a change: " + ", ".join(f"{name} {sigma:+.1f} σ" for name, sigma in nearest))


if __name__ == "__main__":
    main()
