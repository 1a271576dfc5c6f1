"""The progress bar as it is seen on a terminal, and not seen elsewhere."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from diagnosed import saved
from fits import USUAL, recorded, speeds

import network
from network import diagnose
from network.report.progress import Bar, share_bar

BUSY = """
import time
from network.report import progress
from network.report.progress import share_bar
with share_bar("busy with it") as bar:
    bar(0.25)
    while bar._rich is None:  # loaded and begun by another thread
        time.sleep(0.05)
    time.sleep(1.3)
    with share_bar("within") as inner:
        inner(0.5)
        bar._rich.refresh()
progress.PATIENCE = 1000
with share_bar("too short to be seen"):
    pass
"""


def shown(code: str) -> str:
    """What a program writes to a terminal as its standard error."""
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    environment = {**os.environ, "PYTHONPATH": str(Path(network.__file__).parents[1]), "TERM": "xterm", "COLUMNS": "80"}
    program = subprocess.Popen([sys.executable, "-c", code], stderr=theirs, stdout=subprocess.PIPE, env=environment)
    os.close(theirs)
    text = b""
    while True:
        try:
            piece = os.read(ours, 65536)
        except OSError:
            break
        if not piece:
            break
        text += piece
    assert program.wait() == 0 and program.stdout is not None and program.stdout.read() == b""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.decode())


def test_time_goes_on_while_nothing_is_told() -> None:
    text = shown(BUSY)
    assert re.search("busy with it .* 25% 0:00:00", text) and re.search("busy with it .* 25% 0:00:01", text)
    assert re.search("within .* 50%", text) and "too short" not in text


def test_where_nobody_looks_nothing_is_shown(capfd: pytest.CaptureFixture[str]) -> None:
    with share_bar("unseen") as bar:
        bar(0.5)
    assert capfd.readouterr() == ("", "")


def test_what_is_done_within_leaves_the_rest_to_do() -> None:
    """Lumps that are chosen first are not the work: the bar stands where it was, and says what it said."""
    with share_bar("calibrating") as bar:
        bar(0.1)
        with share_bar("choosing lumps") as inner:
            assert (inner, inner.what, inner.share) == (bar, "choosing lumps", 0.0)
            inner(0.98)
        assert (bar.what, bar.share) == ("calibrating", 0.1)


def test_a_diagnosis_says_what_it_is_at(tmp_path: Path) -> None:
    said = list[str]()

    class Ear:
        def __call__(self, share: float) -> None:
            pass

        def now(self, what: str) -> None:
            said.append(what)

    machine = saved(tmp_path)
    diagnose(machine, [recorded(machine, speeds(*USUAL), 1)], progress=Ear(), seconds=60)
    assert "σ left; looking for what is missing" in " ".join(said)
    assert said[-1] == "judging what was found, also on what was held out"


def test_it_never_falls_back_and_follows_several_runs() -> None:
    bar = Bar("runs")
    bar(0.4)
    bar(0.2)
    assert bar.share == 0.4
    bar.now("more", 0.0)
    tell = bar.over([SimpleNamespace(t=[0.0, 10.0]), SimpleNamespace(t=[5.0, 15.0])])
    told = []
    for t in (5.0, 10.0, 5.0, 10.0, 15.0):
        tell(t)
        told.append(bar.share)
    assert told == [0.25, 0.5, 0.5, 0.75, 1.0] and bar.what == "more"
