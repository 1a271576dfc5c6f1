"""A case in a folder: machine and mappings as `lptn` takes them, with what is concealed left out of them."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from bench.rigs.answers import Answer
from bench.rigs.splits import Run, Split

Tree = Mapping[str, Any]
Table = list[list[str]]
"""Header and rows of a recording, as text."""


def as_it_is(tree: Tree) -> Tree:
    return {}


def same_mapping(mapping: Tree, table: Table) -> Tree:
    return mapping


def same_rows(table: Table) -> Table:
    return table


@dataclass(frozen=True)
class Concealment:
    """What is hidden from a split: machine (the file's tree → a patch), mapping (with the table it reads) and rows;
    answer: what a diagnosis should say, given the machine's whole tree; source: entries whose heat is hidden."""

    name: str
    split: str
    hides: str
    answer: Callable[[Tree], Answer]
    machine: Callable[[Tree], Tree] = as_it_is
    mapping: Callable[[Tree, Table], Tree] = same_mapping
    rows: Callable[[Table], Table] = same_rows
    heat: Callable[[Tree], tuple[str, ...]] | None = None


@dataclass(frozen=True)
class Case:
    """A split, as it is or with something concealed."""

    split: Split
    concealed: Concealment | None = None

    @property
    def name(self) -> str:
        return self.concealed.name if self.concealed else self.split.name

    @property
    def tree(self) -> Tree:
        """The machine file with nothing concealed."""
        return read(self.split.machine_file)

    @property
    def answer(self) -> Answer | None:
        return self.concealed.answer(self.tree) if self.concealed else None

    @property
    def train(self) -> tuple[str, ...]:
        return tuple(f"train{i}.yaml" for i, _ in enumerate(self.split.train, start=1))

    @property
    def holdout(self) -> tuple[str, ...]:
        return tuple(f"holdout{i}.yaml" for i, _ in enumerate(self.split.holdout, start=1))

    def write(self, folder: Path) -> None:
        """machine.yaml, train1.yaml …, holdout1.yaml …, and recordings beside them where their rows were changed."""
        folder.mkdir(parents=True, exist_ok=True)
        patch = self.concealed.machine(self.tree) if self.concealed else {}
        dump({"extends": str(self.split.machine_file), **patch}, folder / "machine.yaml")
        names = zip((*self.train, *self.holdout), (*self.split.train, *self.split.holdout), strict=True)
        for name, run in names:
            dump(self._mapping(run, (folder / name).with_suffix(".csv")), folder / name)

    def _mapping(self, run: Run, beside: Path) -> Tree:
        """Of a run; beside: where its rows go if they are changed."""
        mapping = laid_over(run)
        if self.concealed is None:
            return mapping
        table = load_table(Path(mapping["file"]))
        changed = self.concealed.rows(table)
        if changed != table:
            mapping = {**mapping, "file": beside.name}
            save_table(changed, beside)
        return self.concealed.mapping(mapping, changed)


def laid_over(run: Run) -> dict[str, Any]:
    """The mapping of a run, its file by its whole path."""
    mapping = dict(read(run.path))
    file = (run.path.parent / mapping["file"]).resolve()
    over = {**run.over, "file": str(file.with_name(run.over.get("file", file.name)))}
    return {key: value for key, value in {**mapping, **over}.items() if value is not None}


def read(path: Path) -> dict[str, Any]:
    tree: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return tree


def dump(tree: Tree, path: Path) -> None:
    text = yaml.safe_dump(plain(tree), sort_keys=False, allow_unicode=True, width=1000)
    path.write_text(text, encoding="utf-8")


def plain(tree: Any) -> Any:
    return {key: plain(value) for key, value in tree.items()} if isinstance(tree, Mapping) else tree


def load_table(path: Path) -> Table:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def save_table(table: Table, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(table)
