"""`python -m bench.rigs`: real rigs as they are and with something concealed, diagnosed one by one, then measured.

Needs the recordings in ../shared/recordings. A stopped run goes on where it was with the same --resume folder.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from bench.rigs.case import Case
from bench.rigs.concealments import CONCEALMENTS
from bench.rigs.rows import Row, row
from bench.rigs.running import LIMIT, Processes, answered
from bench.rigs.splits import RECORDINGS, SPLITS, split
from bench.rigs.tables import markdown, tables
from rich.console import Console

from network.platform.stopping import on_stop, stoppable

CASES = (*(Case(s) for s in SPLITS), *(Case(split(c.split), c) for c in CONCEALMENTS))


def chosen(words: Sequence[str]) -> list[Case]:
    """Cases whose name or split begins with one of the words."""
    found = [c for c in CASES if not words or any(n.startswith(w) for w in words for n in (c.name, c.split.name))]
    if not found:
        sys.exit(f"no rig or concealment is called so; there are {', '.join(case.name for case in CASES)}")
    return found


def here(cases: Sequence[Case]) -> list[Case]:
    """Those with all their files; the others are told."""
    for case in cases:
        if case.split.lacks:
            print(f"{case.name}: left out, {case.split.lacks[0].name} is not here", file=sys.stderr)
    return [case for case in cases if not case.split.lacks]


def arguments(given: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.rigs", description=__doc__)
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help="rigs and concealments so called")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS", help="of a processor, for each answer")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="diagnoses at a time")
    parser.add_argument("--json", type=Path, metavar="FILE", help="the rows, for machines")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="where answers are kept")
    parser.add_argument("--markdown", action="store_true", help="one markdown table instead")
    return parser.parse_args(given)


@contextmanager
def folder(kept: Path | None) -> Iterator[Path]:
    if kept is not None:
        yield kept.resolve()
        return
    with tempfile.TemporaryDirectory() as name:
        yield Path(name).resolve()


def rows(cases: Sequence[Case], where: Path, limit: float, jobs: int) -> list[Row]:
    """In the order of the cases; told one by one as they come."""
    processes = Processes(limit)
    with stoppable(), on_stop(processes.end), ThreadPoolExecutor(max(1, jobs)) as pool:
        running = [pool.submit(_row, case, where, processes) for case in cases]
        try:
            for done, future in enumerate(as_completed(running), start=1):
                told = future.result()
                print(f"{done}/{len(cases)} {told.name}: {told.told}, {told.seconds:.0f} s", file=sys.stderr)
        except BaseException:
            processes.end()
            pool.shutdown(cancel_futures=True)
            raise
        return [future.result() for future in running]


def _row(case: Case, where: Path, processes: Processes) -> Row:
    return row(answered(case, where, processes))


def main(given: Sequence[str] | None = None) -> None:
    options = arguments(given)
    if not RECORDINGS.is_dir():
        print("the recordings in ../shared/recordings are not here")
        return
    cases = here(chosen(options.only))
    with folder(options.resume) as where:
        found = rows(cases, where, options.limit, options.jobs)
    if options.json:
        options.json.write_text(json.dumps([asdict(r) for r in found], indent=1, ensure_ascii=False), encoding="utf-8")
    if options.markdown:
        print(markdown(found))
        return
    for table in tables(found):
        Console(width=220).print(table)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped; with the same --resume folder it goes on from here")
