"""Recordings: measured channels over time from a CSV, as it is or through a mapping."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot, likely, refuse
from network.recordings.columns import Column, channels
from network.recordings.csv_table import USUAL_UNITS, Heading, read_heading, refuse_twice, table
from network.recordings.inputs import Schedule, Signal, Start, hold, is_slow, linear
from network.recordings.mapping import load_mapping
from network.recordings.yaml_values import collecting


@dataclass(frozen=True, eq=False)
class Recording:
    """Channels over time.

    file: as given by the user; t: [s], strictly increasing, the run starts at t[0]; constants: inputs that a mapping
    gives; fill, between: by name of an input, how its gaps are filled (linear, hold) and how it runs between samples
    (linear, held; default by its unit); source: the CSV, whose line k + 2 holds t[k].
    """

    name: str
    file: str
    t: Array
    columns: Mapping[str, Column]
    constants: Mapping[str, Signal] = field(default_factory=dict)
    start: Start | None = None
    fill: Mapping[str, str] = field(default_factory=dict)
    between: Mapping[str, str] = field(default_factory=dict)
    source: str = ""

    def __str__(self) -> str:
        hours = (self.t[-1] - self.t[0]) / 3600
        return f"{self.name}: {len(self.t)} samples in {hours:.3g} h of {', '.join([*self.columns, *self.constants])}"

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """From a CSV, or from a mapping (.yaml, .yml). Raises Refused with all faults, of many alike the first ones."""
        path = Path(path)
        if path.suffix.lower() in (".yaml", ".yml"):
            return cls(**vars(load_mapping(path)))
        return _load_csv(path)

    def until(self, share: float) -> Recording:
        """Its beginning, to a share of its length."""
        kept = self.t <= self.t[0] + share * (self.t[-1] - self.t[0])
        columns = {n: replace(c, values=c.values[kept]) for n, c in self.columns.items()}
        return replace(self, t=self.t[kept], columns=columns)

    def measured(self, name: str) -> Column:
        """The column. Raises Refused where there is none of that name."""
        return self._column(name, Spot(self.file))

    def signal(self, name: str, spot: Spot | None = None, is_switch: bool = False) -> Signal:
        """A column or constant as an input; `spot` is who asks; is_switch: it is held whatever its unit, unless the
        mapping says otherwise. Raises Refused: not there, or gaps and no way told."""
        if name in self.constants:
            return self.constants[name]
        column = self._column(name, spot or Spot(self.file))
        how = self.between.get(name) or ("linear" if is_slow(unit(column.unit)) and not is_switch else "held")
        return (linear if how == "linear" else hold)(name, column.unit, self.t, self._without_gaps(column))

    def schedule(self, input_names: Iterable[str], switches: Container[str] = ()) -> Schedule:
        """The inputs a machine needs, at the times of the recording; switches: those that say whether something is
        there. Raises Refused with every one that is missing."""
        complaints, signals, known = Complaints(), dict[str, Signal](), [*self.columns, *self.constants]
        for name in input_names:
            with collecting(complaints, Spot(self.file), name):
                if name not in known:
                    raise self._lacks(name, known)
                signals[name] = self.signal(name, is_switch=name in switches)
        complaints.raise_if_any()
        return Schedule(self.name, self.file, self.t, signals, self.start)

    def _lacks(self, name: str, known: Sequence[str]) -> Exception:
        near = likely(name, known)
        right = f"add a column `{name} [{USUAL_UNITS.get(name, 'unit')}]`, or `inputs: {{{name}: …}}` in a mapping"
        right += f" ({near})" if near.startswith("did") else ""
        return refuse(Spot(self.file), f"the machine needs the input `{name}`, which the recording lacks", right)

    def _column(self, name: str, spot: Spot) -> Column:
        if name not in self.columns:
            raise refuse(spot, f"the recording '{self.name}' has no column '{name}'", likely(name, self.columns))
        return self.columns[name]

    def _without_gaps(self, column: Column) -> Array:
        values, how = column.values, self.fill.get(column.name)
        known = np.flatnonzero(np.isfinite(values))
        if len(known) == len(values):
            return values
        if how and len(known):
            if how == "linear":
                return np.interp(self.t, self.t[known], values[known])
            latest = np.searchsorted(known, np.arange(len(values)), side="right") - 1
            return values[known[np.clip(latest, 0, None)]]
        first = int(np.argmax(~np.isfinite(values)))
        spot = Spot(self.source, first + 2) if self.source else Spot(self.file)
        count = f"{len(values) - len(known)} of {len(values)} times, first at {self.t[first]:.10g} s"
        wrong = f"the input '{column.name}' has no value at {count}"
        right = f"fill them in, or read it through a mapping with `fill: {{{column.name}: linear}}` (or hold)"
        raise refuse(spot, wrong, right if len(known) else "give it values, it has none")


def _load_csv(path: Path) -> Recording:
    complaints, spot = Complaints(), Spot(str(path), 1)

    def choose(header: list[str], complaints: Complaints) -> list[Heading]:
        headings = []
        for index, text in enumerate(header):
            with collecting(complaints, spot, f"column '{text}'" if text else f"column {index + 1}"):
                headings.append(replace(read_heading(text), index=index))
        refuse_twice([heading.name for heading in headings], spot, complaints)
        if not any(text.partition("[")[0].strip() == "time" for text in header):
            near = likely("time", header)
            right = "name one `time [s]`, `time [min]` or `time [h]`" + (f" ({near})" if near.startswith("did") else "")
            complaints.refuse(spot, "has no time column", right)
        return headings

    headings, cells = table(path, choose, complaints)
    t, columns = channels(headings, cells, str(path), None, complaints)
    complaints.raise_if_any()
    return Recording(path.stem, str(path), t, columns, source=str(path))
