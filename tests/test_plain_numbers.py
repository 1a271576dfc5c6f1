"""Plain numbers read by blocks are those that are read cell by cell; the rest is left to the way that explains."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from network.recordings import plain_numbers
from network.recordings.plain_numbers import read_plain_numbers


def write(folder: Path, text: str) -> Path:
    path = folder / "r.csv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("block", [3, 17, 1 << 24])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("last", ["", "END"])
def test_gaps_ends_of_lines_and_blocks(block: int, end: str, last: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(plain_numbers, "_BLOCK", block)
    rows = ["0,1.5,-2e3", ",,", "2,,nan", ",4,", "1e-5,7,8"]
    text = end.join(["a,b,c", *rows]) + (end if last else "")
    found = read_plain_numbers(write(tmp_path, text), 3, [0, 2])
    nan = np.nan
    np.testing.assert_array_equal(found, [[0, -2000], [nan, nan], [2, nan], [nan, nan], [1e-5, 8]])


@pytest.mark.parametrize(
    "rows",
    ["1,2\n\n3,4", "1,2\n3", "1,2\n3,4,5", "1,x\n3,4", '"1",2\n3,4', "1 2,3\n4,5", "1,2\n 3 4,5", "1;2\n3;4", "",
     "1,2é\n3,4", "0x10,2\n3,4", "1_0,2\n3,4", "1,2,3\n4"],
)  # fmt: skip
def test_what_is_not_plain_is_left_alone(rows: str, tmp_path: Path) -> None:
    assert read_plain_numbers(write(tmp_path, f"a,b\n{rows}\n" if rows else "a,b\n"), 2, [0, 1]) is None


def test_every_digit_is_kept(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(size=(1000, 2)) * 10.0 ** np.arange(-3, 997)[:, None].clip(max=250)
    rows = "\n".join(",".join(map(repr, row)) for row in values.tolist())
    found = read_plain_numbers(write(tmp_path, f"a,b\n{rows}\n"), 2, [0, 1])
    np.testing.assert_array_equal(found, values)


@pytest.mark.parametrize("rows", ["1\n\n2", "\n1", " \n1", "1\n \n2"])
def test_an_empty_line_is_no_gap(rows: str, tmp_path: Path) -> None:
    assert read_plain_numbers(write(tmp_path, f"a\n{rows}\n"), 1, [0]) is None


def test_what_is_taken_is_what_its_letters_say() -> None:
    """Cells of letters drawn at random: refused, or the number that Python reads."""
    chance, taken = random.Random(1), 0
    for _ in range(20_000):
        cells = ["".join(chance.choices("0123456789+-.eEnaN \t_xif\r", k=chance.randint(0, 5))) for _ in range(2)]
        found = plain_numbers._numbers_of(f"{cells[0]},{cells[1]}\n".encode(), 2, [0, 1])
        if found is not None:
            taken += 1
            np.testing.assert_array_equal(found[0], [float(cell.strip() or "nan") for cell in cells])
    assert taken > 1000
