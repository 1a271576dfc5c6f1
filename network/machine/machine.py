"""A machine: nodes, links, sources, how temperature moves the tool centre point, sensors. Read from YAML, patched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.sections import check_sections
from network.machine.checks import check_machine
from network.machine.entries import Entries
from network.machine.file_layers import load_tree
from network.machine.lumps import level_patch
from network.machine.overrides import set_lumps, set_value
from network.machine.reader import MachineReader
from network.platform.printing import tell
from network.platform.refusal import Complaints, Spot
from network.platform.yaml.document import Branch


@dataclass(frozen=True)
class Machine(Entries):
    """The entries of a machine file, checked; from a file, and with patches laid over it."""

    @classmethod
    def load(
        cls, path: str | Path, *, level: str | None = None, lumps: Sequence[str | int] = (), sets: Sequence[str] = ()
    ) -> Self:
        """The machine of a YAML file, patched by a named level, lump counts and `path=value` settings, in that order.

        Raises Refused with every fault of the file.
        """
        complaints = Complaints()
        machine = cls.read(load_tree(Path(path), complaints), str(path), complaints)
        if level is not None:
            machine = cls.read(level_patch(machine, level), str(path))
        tree = machine.tree
        for wish in lumps:
            tree = set_lumps(tree, str(wish))
        for assignment in sets:
            tree = set_value(tree, assignment)
        return machine if tree is machine.tree else cls.read(tree, str(path))

    @classmethod
    def read(cls, tree: Branch, file: str, complaints: Complaints | None = None) -> Self:
        """The machine of a merged tree. Raises Refused with every fault found, those already in `complaints` too."""
        collected = complaints or Complaints()
        check_sections(tree, collected)
        machine = MachineReader(tree, file, collected).machine(cls)
        check_machine(machine, collected)
        collected.raise_if_any()
        return replace(machine, warnings=tuple(sorted(set(collected.warnings))))

    def patched(self, patch: Mapping[str, Any], origin: str = "patch") -> Self:
        """This machine with a patch laid over it; `origin` stands in messages. Raises Refused."""
        return self.read(Patch(patch).over(self.tree, Spot(origin)), self.file)

    def __str__(self) -> str:
        return tell(self)
