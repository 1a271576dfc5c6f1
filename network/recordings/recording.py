"""Recordings: measured channels over time from a CSV, as it is or through a mapping."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.platform.data_frame import data_frame
from network.platform.printing import Result
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot, UnknownName, likely, refuse
from network.recordings.columns import Column, channels
from network.recordings.csv_table import Heading, read_heading, refuse_twice, table, usual_unit
from network.recordings.hygiene.set_aside import SetAside
from network.recordings.inputs import Schedule, Signal, Start, hold, is_slow, is_stepped, linear
from network.recordings.mapping import load_mapping
from network.recordings.pieces import Cut, extents, find_cuts, piece_column, tell_cuts
from network.recordings.relay_mode import RelayMode
from network.recordings.stamps import AUTO
from network.recordings.table_rows import Header
from network.recordings.yaml_values import collecting

BEGINNINGS = 64
"""Beginnings of recordings that are remembered: fits over ever more of them lay the same ones out alike."""


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Result):
    """Channels over time.

    file: as given by the user; t: [s], the run starts at t[0] and t increases, within each piece where cuts part it;
    constants: inputs that a mapping gives; fill, between: by name of an input, how its gaps are filled (linear, hold)
    and how it runs between samples (linear, held; default by its unit); source: the CSV, whose line lines[k] holds
    t[k] (k + 2 without); zeroed: channels told less their first value; excluded: what was set aside of it, None before
    it was judged; offsets: whether its sensors may be off by a constant; starts: whether its parts may begin
    elsewhere than the start rule says; modes: whether a relay of the machine is on (1) or off (0), by its name, where
    readings of what it watches, or all readings together, tell.
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
    lines: Indices | None = None
    cuts: tuple[Cut, ...] = ()
    zeroed: tuple[str, ...] = ()
    excluded: tuple[SetAside, ...] | None = None
    offsets: bool = True
    starts: bool = True
    modes: Mapping[str, RelayMode] = field(default_factory=dict)

    def __str__(self) -> str:
        hours = (self.t[-1] - self.t[0]) / 3600
        return f"{self.name}: {len(self.t)} samples in {hours:.3g} h of {', '.join([*self.columns, *self.constants])}"

    def shown(self, name: str) -> Array:
        """A column in its unit. Raises UnknownName, which says what there is."""
        if name not in self.columns:
            raise UnknownName(f"{self.name} has no column '{name}'; {likely(name, self.columns)}")
        return self.columns[name].shown

    def to_pandas(self) -> Any:
        """A data frame over time [s] of all columns in their units. Raises ImportError without pandas."""
        columns = ((name, column.unit, column.shown) for name, column in self.columns.items())
        return data_frame(columns, ("time", "s", self.t))

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """From a CSV, or from a mapping (.yaml, .yml). Raises Refused with all faults, of many alike the first ones."""
        path = Path(path)
        if path.suffix.lower() in (".yaml", ".yml"):
            return cls(**vars(load_mapping(path)))
        return _load_csv(path)

    @property
    def pieces(self) -> tuple[Recording, ...]:
        """The runs that it holds: itself, or `file, part 1`, `file, part 2` … where it is parted. `start` is that of
        the first, the others begin at their first readings."""
        parts = extents(len(self.t), self.cuts)
        return tuple(self._piece(part, number) for number, part in enumerate(parts, 1)) if self.cuts else (self,)

    def _piece(self, part: slice, number: int) -> Recording:
        columns = {n: piece_column(c, part, n in self.zeroed) for n, c in self.columns.items()}
        lines = np.arange(len(self.t)) + 2 if self.lines is None else self.lines
        return replace(
            self, name=f"{self.name}, part {number}", file=f"{self.file}, part {number}", t=self.t[part],
            columns=columns, lines=lines[part], cuts=(), start=self.start if part.start == 0 else None,
        )  # fmt: skip

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be told of how it was read."""
        return tell_cuts(self.file, self.t, self.cuts)

    def until(self, share: float) -> Recording:
        """Its beginning, to a share of its length; the same one as long as it is remembered."""
        return _begin(self, share)

    def before(self, t: float) -> Recording:
        """What was recorded before an instant [s]."""
        return self._keep(self.t < t)

    def _keep(self, kept: Mask) -> Recording:
        columns = {n: c.keep(kept) for n, c in self.columns.items()}
        t, lines = self.t[kept], None if self.lines is None else self.lines[kept]
        modes = {n: m.until(float(t[-1])) for n, m in self.modes.items()}
        return replace(self, t=t, columns=columns, lines=lines, modes=modes)

    def measured(self, name: str) -> Column:
        """The column. Raises Refused where there is none of that name."""
        return self._column(name, Spot(self.file))

    def signal(self, name: str, spot: Spot | None = None, is_switch: bool = False) -> Signal:
        """A column or constant as an input; `spot` is who asks; is_switch: it is held whatever its unit, unless the
        mapping says otherwise. Raises Refused: not there, or gaps and no way told."""
        if name in self.constants:
            return self.constants[name]
        if name in self.modes:
            return self.modes[name].signal
        column = self._column(name, spot or Spot(self.file))
        read = unit(column.unit)
        is_held = is_switch or not is_slow(read) or is_stepped(read, column.values)
        how = self.between.get(name) or ("held" if is_held else "linear")
        return (linear if how == "linear" else hold)(name, column.unit, self.t, self._without_gaps(column))

    def schedule(self, input_names: Iterable[str], switches: Container[str] = ()) -> Schedule:
        """The inputs a machine needs, at the times of the recording; switches: those that say whether something is
        there. Raises Refused with every one that is missing."""
        complaints, signals, known = Complaints(), dict[str, Signal](), [*self.columns, *self.constants, *self.modes]
        for name in input_names:
            with collecting(complaints, Spot(self.file), name):
                if name not in known:
                    raise self._lacks(name, known)
                signals[name] = self.signal(name, is_switch=name in switches)
        complaints.raise_if_any()
        return Schedule(self.name, self.file, self.t, signals, self.start)

    def _lacks(self, name: str, known: Sequence[str]) -> Exception:
        near = likely(name, known)
        right = f"add a column `{name} [{usual_unit(name) or 'unit'}]`, or `inputs: {{{name}: …}}` in a mapping"
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
        line = first + 2 if self.lines is None else int(self.lines[first])
        spot = Spot(self.source, line) if self.source else Spot(self.file)
        count = f"{len(values) - len(known)} of {len(values)} times, first at {self.t[first]:.10g} s"
        wrong = f"the input '{column.name}' has no value at {count}"
        right = f"fill them in, or read it through a mapping with `fill: {{{column.name}: linear}}` (or hold)"
        raise refuse(spot, wrong, right if len(known) else "give it values, it has none")


@lru_cache(maxsize=BEGINNINGS)
def _begin(recording: Recording, share: float) -> Recording:
    return recording._keep(recording.t <= recording.t[0] + share * (recording.t[-1] - recording.t[0]))


def _load_csv(path: Path) -> Recording:
    complaints = Complaints()

    def choose(header: Header, complaints: Complaints) -> list[Heading]:
        headings, told, spot = [], header.told, Spot(str(path), header.line)
        for index, text in enumerate(told):
            if text == "time":
                headings.append(Heading("time", unit("s"), text, index, AUTO))
                continue
            with collecting(complaints, spot, f"column '{text}'" if text else f"column {index + 1}"):
                headings.append(replace(read_heading(text), index=index))
        refuse_twice([heading.name for heading in headings], spot, complaints)
        if not any(text.partition("[")[0].strip() == "time" for text in told):
            near = likely("time", told)
            right = "name one `time [s]`, `time [min]` or `time [h]`" + (f" ({near})" if near.startswith("did") else "")
            complaints.refuse(spot, "has no time column", right)
        return headings

    read = table(path, choose, complaints)
    complaints.raise_if_any()
    samples = channels([read], None)
    cuts = find_cuts(samples, complaints)
    complaints.raise_if_any()
    return Recording(path.stem, str(path), samples.t, samples.columns, source=str(path), lines=samples.lines, cuts=cuts)
