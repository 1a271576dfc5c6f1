"""Guards that a NaN does not slip through: `if value < 0: refuse` takes NaN, `if not value >= 0: refuse` does not.

Every `if` in the package whose body raises or refuses is looked at. A comparison by order in it stands under a `not`,
unless what is compared is a count.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import network

ROOT = Path(network.__file__).parent
ORDER = (ast.Lt, ast.Gt, ast.LtE, ast.GtE)
COUNTS = re.compile(r"\b(len|int|set|prod)\(|\b(count|jobs|lumps|size|st_size)\b|kept\.sum\(\)|is not None for")
"""What can only be whole numbers."""
MEANT = {
    "recordings/scenario_inputs.py: length <= 0": "NaN stands for a fault that is told already",
    "recordings/scenario_inputs.py: after < 0": "NaN stands for a fault that is told already",
    "recordings/scenario_phases.py: edges[-1] >= duration": "NaN stands for a fault of an earlier row",
    "analysis/calibration/recording_admission.py: lasts < fastest": "both were computed from finite times",
}


def refuses(body: list[ast.stmt]) -> bool:
    return any(
        isinstance(node, ast.Raise)
        or (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "refuse")
        for statement in body
        for node in ast.walk(statement)
    )


def let_nan_pass(test: ast.expr, denied: bool = False) -> Iterator[ast.Compare]:
    """Comparisons by order that are false for NaN, and so keep a guard from refusing it."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        yield from let_nan_pass(test.operand, not denied)
    elif isinstance(test, ast.BoolOp):
        for value in test.values:
            yield from let_nan_pass(value, denied)
    elif isinstance(test, ast.Compare) and not denied and any(isinstance(sign, ORDER) for sign in test.ops):
        yield test


def leaky(source: str) -> list[str]:
    guards = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.If) and refuses(node.body)]
    found = [ast.unparse(each) for guard in guards for each in let_nan_pass(guard.test)]
    return [text for text in found if not COUNTS.search(text)]


@pytest.mark.parametrize(
    ("guard", "is_leaky"),
    [
        ("value < 0", True), ("not value >= 0", False), ("not 0 <= value <= 1", False), ("a and value > b", True),
        ("not (value > 0 and value < 1)", False), ("len(rows) < 2", False), ("value == 0", False),
    ],
)  # fmt: skip
def test_the_rule_itself(guard: str, is_leaky: bool) -> None:
    for body in ("raise ValueError", "complaints.refuse(spot, wrong, right)"):
        assert bool(leaky(f"if {guard}:\n    {body}\n")) == is_leaky
    assert not leaky(f"if {guard}:\n    pass\n")


def test_no_guard_lets_nan_pass() -> None:
    files = sorted(ROOT.rglob("*.py"))
    found = [f"{path.relative_to(ROOT)}: {text}" for path in files for text in leaky(path.read_text(encoding="utf-8"))]
    assert len(files) > 300 and [each for each in found if each not in MEANT] == []
