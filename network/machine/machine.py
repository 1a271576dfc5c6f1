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
from network.machine.increment import AS_READ, extend
from network.machine.lumps import level_patch
from network.machine.overrides import part_numbers, set_lumps, set_value
from network.machine.reader import MachineReader
from network.platform.printing import Drawn
from network.platform.refusal import Complaints, Spot
from network.platform.yaml.document import Branch


@dataclass(frozen=True, repr=False)
class Machine(Entries, Drawn):
    """The entries of a machine file, checked; from a file, and with patches laid over it."""

    @classmethod
    def load(
        cls, path: str | Path, *, level: str | None = None, lumps: str | int | Sequence[str | int] = (),
        sets: str | Sequence[str] = (),
    ) -> Self:  # fmt: skip
        """The machine of a YAML file, patched by a named level, lump counts and settings, in that order.

        level: like 'fine'; lumps: like 8 for every bar, ['housing=8'] for one (as many as it takes: `choose_lumps`);
        sets: like ['links.flange.conductance=60 W/K'], as `--set` has them. Raises Refused with every fault of the
        file.
        """
        complaints = Complaints()
        machine = cls.read(load_tree(Path(path), complaints), str(path), complaints)
        if level is not None:
            machine = cls.read(level_patch(machine, level), str(path))
        tree = machine.tree
        for wish in [lumps] if isinstance(lumps, str | int) else lumps:
            tree = set_lumps(tree, str(wish))
        for assignment in [sets] if isinstance(sets, str) else sets:
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
        machine = replace(machine, warnings=tuple(sorted(set(collected.warnings))))
        machine.__dict__[AS_READ] = True
        return machine

    def patched(self, patch: Mapping[str, Any], origin: str = "patch") -> Self:
        """This machine with a patch laid over it; `origin` stands in messages. Raises Refused.

        An entry given replaces the whole entry of that name, None takes it out. Single numbers are exchanged by their
        path, as in `{"links.flange.conductance": "60 W/K"}`, or in an entry that names no kind, as in
        `{"links": {"flange": {"conductance": "60 W/K"}}}`.
        """
        if not isinstance(patch, Mapping):
            right = '{"links.flange.conductance": "60 W/K"}'
            raise TypeError(f"patch is a mapping like {right}, not {type(patch).__name__} {patch!r}")
        whole, numbers = part_numbers(patch, self.tree)
        tree = Patch(whole).over(self.tree, Spot(origin)) if whole else self.tree
        for path, value in numbers:
            tree = set_value(tree, f"{path}={value}")
        return extend(self, tree) or self.read(tree, self.file)
