"""Results in a folder: the old one or the new one, whole, whatever happens meanwhile."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

import network
from network.cli import main
from network.platform import held_folder, publication
from network.platform.files import replace_file, write_text
from network.platform.processes import pool_of
from network.platform.publication import Kind
from network.platform.refusal import Refused

ROOT = Path(network.__file__).parents[1]
BLOCKS, WARM_UP = (str(ROOT / name) for name in ("machines/two_blocks.yaml", "scenarios/bearing_warms.yaml"))
NAMES = ("a.csv", "b.json", "new.txt")
OLD = {"a.csv": "old", "b.json": "old", "one.png": "old", "mine.png": "mine"}
NEW = {"a.csv": "new", "b.json": "new", "new.txt": "new", "mine.png": "mine"}
KIND = Kind("b.json", ("*.png",))
DRAFT, OTHERS = ".lptn-draft-0123456789abcdef", (".calibration.mine", ".diagnosis.mine", ".x.part", ".lptn-draft-mine")
posix = pytest.mark.skipif(os.name != "posix", reason="folders are locked there")


def publish(where: Path, names: tuple[str, ...] = NAMES, text: str = "new") -> None:
    with publication.publication(where, KIND) as draft:
        for name in names:
            write_text(draft / name, text)


def with_old(where: Path) -> Path:
    """A folder with an old result of two files and a picture, and a picture of the user's."""
    where.mkdir()
    publish(where, ("a.csv", "b.json", "one.png"), "old")
    (where / "mine.png").write_text("mine")
    os.utime(where / "mine.png", (0, 0))
    return where


def held(where: Path) -> dict[str, str]:
    """Everything in it, hidden folders too."""
    return {path.name: path.read_text() if path.is_file() else "folder" for path in where.iterdir()}


def test_a_result_comes_whole_and_takes_the_pictures_of_the_old_one_away(tmp_path: Path) -> None:
    where = with_old(tmp_path / "out")
    assert held(where) == OLD
    publish(where)
    assert held(where) == NEW


class Saboteur:
    """Steps on the way to a folder, one of which fails, before it is done or after."""

    def __init__(self, patch: pytest.MonkeyPatch, failure: BaseException, step: int, late: bool) -> None:
        self.failure, self.left, self.late = failure, step, late
        for owner, names in ((os, ("replace", "link", "utime")), (Path, ("rename", "unlink"))):
            for name in names:
                patch.setattr(owner, name, self.spoil(getattr(owner, name)))

    def spoil(self, real: Callable[..., object]) -> Callable[..., object]:
        def act(*a: object, **k: object) -> object:
            self.left -= 1
            if self.left == -1 and not self.late:
                raise self.failure
            done = real(*a, **k)
            if self.left == -1:
                raise self.failure
            return done

        return act


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("failure", [OSError(errno.EPERM, "no"), KeyboardInterrupt()])
def test_whatever_fails_on_the_way_the_old_result_is_back(
    failure: BaseException, late: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = 0
    for step in range(40):
        where = with_old(tmp_path / f"out {step}")
        with monkeypatch.context() as patch:
            saboteur = Saboteur(patch, failure, step, late)
            try:
                publish(where)
            except (Refused, KeyboardInterrupt):
                kept += 1
        assert held(where) in (OLD, NEW)
        if saboteur.left >= 0:
            break
    assert held(where) == NEW and kept >= 8


def test_a_stop_on_the_way_leaves_nothing_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By Ctrl-C at every step, also of those by which the draft is removed."""
    left, seen, stops = [0], 0, 0

    def stopping(real: Callable[..., object]) -> Callable[..., object]:
        def act(*a: object, **k: object) -> object:
            left[0] -= 1
            if left[0] == -1:
                signal.raise_signal(signal.SIGINT)
            return real(*a, **k)

        return act

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for step in range(60):
            where, left[0] = with_old(tmp_path / f"out {step}"), step
            with monkeypatch.context() as patch, suppress(KeyboardInterrupt):
                for name in ("mkdir", "replace", "rename", "link", "utime", "unlink", "rmdir"):
                    patch.setattr(os, name, stopping(getattr(os, name)))
                stops += 1
                publish(where)
                stops -= 1
            assert held(where) in (OLD, NEW), step
            seen = max(seen, step - left[0])
    finally:
        signal.signal(signal.SIGINT, before)
    assert stops == seen >= 12


KILLED = """
import os, sys
sys.path[:0] = [{root!r}, {tests!r}]
from pathlib import Path
from test_publication import publish
left = [{step}]
def kill_at(real):
    def act(*a, **k):
        left[0] -= 1
        if left[0] < 0:
            os.kill(os.getpid(), 9)
        return real(*a, **k)
    return act
os.replace = kill_at(os.replace)
Path.rename = kill_at(Path.rename)
publish(Path({where!r}))
"""


@posix
@pytest.mark.parametrize(("step", "expected"), [(0, OLD), (1, NEW), (2, NEW), (3, NEW)])
def test_what_a_killed_process_left_is_finished_or_removed(step: int, expected: dict[str, str], tmp_path: Path) -> None:
    where = with_old(tmp_path / "out")
    code = KILLED.format(root=str(ROOT), tests=str(Path(__file__).parent), step=step, where=str(where))
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == -9
    assert any(name.startswith(".lptn-") for name in held(where))
    write_text(where / "next.txt", "next")
    assert held(where) == {**expected, "next.txt": "next"}


@posix
def test_only_what_is_abandoned_goes(tmp_path: Path) -> None:
    for name in OTHERS:
        (tmp_path / name).mkdir()
    with publication.publication(tmp_path) as mine:
        write_text(mine / "a.csv", "mine")
        (tmp_path / DRAFT / "new").mkdir(parents=True)
        publish(tmp_path)
        assert (mine / "a.csv").read_text() == "mine" and not (tmp_path / DRAFT).exists()
        assert (tmp_path / "a.csv").read_text() == "new"
    assert (tmp_path / "a.csv").read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {*OTHERS, *NAMES}


@posix
def test_files_of_killed_processes_go_with_the_next_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    (tmp_path / ".lptn-jobs-0123456789abcdef").mkdir()
    with pool_of(2) as one, pool_of(2) as other:
        assert {*tmp_path.iterdir()} == {one.folder, other.folder}
    assert not [*tmp_path.iterdir()]


def test_a_folder_that_cannot_be_locked_takes_results_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_folder, "fcntl", None)
    where = with_old(tmp_path / "out")
    publish(where)
    assert held(where) == NEW


def test_where_files_have_one_name_only_they_are_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EPERM, "no links here")

    monkeypatch.setattr(os, "link", refuse)
    where = with_old(tmp_path / "out")
    publish(where)
    assert held(where) == NEW


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_in_the_way_leaves_everything_as_it_was(name: str, tmp_path: Path) -> None:
    where = with_old(tmp_path / "out")
    (where / name).unlink(missing_ok=True)
    (where / name).mkdir()
    before = held(where)
    with pytest.raises(Refused, match=f"{name}: is a folder; give another -o"):
        publish(where)
    assert held(where) == before


def test_a_full_disk_is_told_by_the_file_it_met(tmp_path: Path) -> None:
    def fill(path: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with (
        pytest.raises(Refused, match=r"out/a\.csv: cannot be written: No space left on device"),
        publication.publication(tmp_path / "out") as draft,
    ):
        replace_file(draft / "a.csv", fill)
    assert not [*tmp_path.iterdir()]


def test_a_run_that_cannot_be_written_leaves_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*words: str) -> int:
        with pytest.raises(SystemExit) as left:
            main(["simulate", BLOCKS, WARM_UP, *words])
            raise SystemExit(0)
        return int(left.value.code or 0)

    monkeypatch.chdir(tmp_path)
    assert run() == 0
    before = {path: path.read_bytes() for path in Path("out").iterdir()}
    Path("out/parts.csv").unlink()
    Path("out/parts.csv").mkdir()
    assert run("--start", "30 degC") == 2
    assert "parts.csv: is a folder" in capsys.readouterr().err
    Path("out/parts.csv").rmdir()
    assert all(path.read_bytes() == content for path, content in before.items() if path.name != "parts.csv")
    assert run("--no-plots") == 0
    assert {path.name for path in Path("out").iterdir()} == {"results.csv", "parts.csv", "summary.json"}
