"""Commands stopped at random instants, from the first import to the last file: what lay in the folder before or the new
result lies there afterwards, whole; nothing hidden stays where the command could tidy up; the same command then works.

    python -m torture.stops --count 60
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
MACHINE, SCENARIO = str(ROOT / "machines/two_blocks.yaml"), str(ROOT / "scenarios/bearing_warms.yaml")
COMMANDS = {
    "simulate": ((MACHINE, SCENARIO), (MACHINE, SCENARIO, "--set", "sources.heater.power=20 W")),
    "sweep": ((MACHINE, SCENARIO, "--levels", "1,2"), (MACHINE, SCENARIO, "--levels", "1,2,4")),
}
"""What makes the result before, and the one that is stopped."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
PASSING = ("solve_seconds",)
"""Of a result, what differs from run to run."""


def start(command: str, words: tuple[str, ...], where: Path) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    line = [sys.executable, "-m", "network.cli", command, *words, "-o", "out"]
    return subprocess.Popen(
        line, cwd=where, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )


def held(where: Path) -> dict[str, object]:
    """Every file of a result, hidden ones aside, without what passes; of pictures and times of solving their names."""
    return {path.name: _content(path) for path in sorted(where.glob("*")) if not path.name.startswith(".")}


def _content(path: Path) -> object:
    if path.suffix == ".json":
        return _without_passing(json.loads(path.read_text(encoding="utf-8")))
    return None if path.name in ("sweep.csv", "sweep.png") else path.read_bytes()


def _without_passing(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _without_passing(child) for key, child in value.items() if key not in PASSING}
    return [_without_passing(child) for child in value] if isinstance(value, list) else value


def stop_once(command: str, number: signal.Signals, share: float, folder: Path) -> str:
    """What went wrong; empty where nothing did. share: of the time that the command takes, when it is stopped."""
    before, after = COMMANDS[command]
    results = {}
    for name, words in (("before", before), ("after", after)):
        where = folder / f"{command} {name}"
        if not where.exists():
            where.mkdir()
            began = time.monotonic()
            assert start(command, words, where).wait() == 0
            (where / "seconds").write_text(str(time.monotonic() - began))
        results[name] = held(where / "out")
    seconds = float((folder / f"{command} after" / "seconds").read_text())
    where = folder / f"stop {len([*folder.iterdir()])}"
    shutil.copytree(folder / f"{command} before", where)
    running = start(command, after, where)
    time.sleep(share * seconds)
    running.send_signal(number)
    running.wait()
    found, hidden = held(where / "out"), [*(where / "out").glob(".*")]
    if found not in results.values():
        return f"mixed: {sorted(found)}"
    if hidden and number != signal.SIGKILL:
        return f"hidden: {hidden}"
    again = start(command, after, where).wait()
    left = [*(where / "out").glob(".*")]
    return f"again: status {again}, hidden {left}" if again or left or held(where / "out") != results["after"] else ""


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture.stops", description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    chance, told = random.Random(given.seed), Counter[str]()
    with tempfile.TemporaryDirectory(prefix="torture-") as folder:
        for _ in range(given.count):
            command, number = chance.choice([*COMMANDS]), chance.choice(SIGNALS)
            why = stop_once(command, number, chance.uniform(0, 1.1), Path(folder))
            told[f"{command} {number.name}: {why or 'held'}"] += 1
            if why:
                print(f"{command} {number.name}: {why}", file=sys.stderr, flush=True)
    print("\n".join(f"{count:5} {what}" for what, count in sorted(told.items())))
    return int(any(not what.endswith("held") for what in told))


if __name__ == "__main__":
    sys.exit(main())
