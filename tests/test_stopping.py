"""Commands that are stopped: they end soon, with what they started, and leave nothing half-written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import network

ROOT = Path(network.__file__).parents[1]
PROVE = """
import sys
from network.cli import proof, proof_case
from network.cli import main

def make_cases(folder, count, seed, jobs):
    names = [f"case-{i:03d}" for i in range(count)]
    for name in names:
        (folder / name).mkdir(parents=True)
    return names

proof._module("cases").make_cases = make_cases
proof_case.COMMAND = (sys.executable, "sleeper.py")
proof_case.TRAIN = ()
main(["prove", "--cases", "3", "--jobs", "2", "-o", "a/proof"])
"""
SLEEPER = "import os, pathlib, time\npathlib.Path('../../..', f'{os.getpid()}.pid').touch()\ntime.sleep(1000)\n"
DEAF = """
import multiprocessing, pathlib, time
from network.cli import cli, main
from network.platform.publication import publication

@cli.command()
def deaf():
    with publication("new/out") as draft:
        pathlib.Path(draft, "run.png").touch()
        be_deaf()

def be_deaf():
    multiprocessing.get_context("fork").Process(target=time.sleep, args=(1000,)).start()
    pathlib.Path("begun.pid").touch()
    while True:
        try:
            time.sleep(1000)
        except KeyboardInterrupt:
            pass

main(["deaf"])
"""


HANGS = 60
"""s: a command that is stopped takes two; where processors are busy with other things it may take many times that, and
one that hangs never ends."""
LOADING = """
import builtins, os, signal, sys
real, left = builtins.__import__, [int(sys.argv[1])]
def interrupted(name, *rest):
    left[0] -= name.startswith("network")
    if left[0] == 0:
        os.kill(os.getpid(), signal.SIGINT)
    return real(name, *rest)
from network.cli import main
builtins.__import__ = interrupted
main(["paper"])
"""


def begun(code: str, where: Path, count: int) -> subprocess.Popen[str]:
    """The program, when there are as many `.pid` files as it leaves."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code]
    program = subprocess.Popen(
        command, cwd=where, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    until = time.monotonic() + 2 * HANGS
    while len([*where.glob("*.pid")]) < count and time.monotonic() < until:
        time.sleep(0.05)
    return program


def is_gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_proof_that_is_stopped_ends_with_its_diagnoses(tmp_path: Path, number: signal.Signals) -> None:
    sleeper = tmp_path / "sleeper.py"
    sleeper.write_text(SLEEPER)
    program = begun(PROVE.replace("sleeper.py", str(sleeper)), tmp_path, 2)
    program.send_signal(number)
    _, told = program.communicate(timeout=HANGS)
    assert program.returncode == 130 and told.strip() == "lptn: stopped; nothing half-written was left"
    pids = [int(path.stem) for path in tmp_path.glob("*.pid")]
    assert len(pids) == 2 and all(map(is_gone, pids)) and not (tmp_path / "a").exists()


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups")
def test_a_command_ends_even_if_its_interrupt_is_lost(tmp_path: Path) -> None:
    program = begun(DEAF, tmp_path, 1)
    os.killpg(program.pid, signal.SIGINT)
    _, told = program.communicate(timeout=HANGS)
    assert program.returncode == 130 and told.strip() == "lptn: stopped; nothing half-written was left"
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("imports", [1, 2, 7, 30])
def test_a_command_can_be_stopped_while_it_is_loaded(imports: int) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", LOADING, str(imports)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 130 and done.stderr.strip() == "lptn: stopped; nothing half-written was left"


TELLS = """
import pathlib, time
from network.cli import cli, main
from network.platform.stopping import time_to_tell

@cli.command()
def tells():
    with time_to_tell(1000):
        try:
            pathlib.Path("begun.pid").touch()
            time.sleep(1000)
        except KeyboardInterrupt:
            pathlib.Path("stopped.pid").touch()
            time.sleep(SECONDS)
            pathlib.Path("best").touch()
            raise

main(["tells"])
"""


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups")
def test_what_has_time_to_tell_the_best_so_far_takes_it(tmp_path: Path) -> None:
    program = begun(TELLS.replace("SECONDS", "3"), tmp_path, 1)
    program.send_signal(signal.SIGINT)
    _, told = program.communicate(timeout=HANGS)
    assert program.returncode == 130 and (tmp_path / "best").exists()
    assert [line for line in told.splitlines() if line] == [
        "lptn: stopped; the best so far is being written, stop again to end at once",
        "lptn: stopped; nothing half-written was left",
    ]


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="process groups")
def test_a_second_stop_ends_it_at_once(tmp_path: Path) -> None:
    program = begun(TELLS.replace("SECONDS", "1000"), tmp_path, 1)
    program.send_signal(signal.SIGINT)
    until = time.monotonic() + HANGS
    while not (tmp_path / "stopped.pid").exists() and time.monotonic() < until:
        time.sleep(0.05)
    program.send_signal(signal.SIGINT)
    program.communicate(timeout=HANGS)
    assert program.returncode == 130 and not (tmp_path / "best").exists()
