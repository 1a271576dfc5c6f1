"""Tables as Parquet, by pyarrow where it is installed: a tenth of the time and a third of the room of text, exact."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.files import replace_file
from network.platform.quantities.unit_values import in_own_unit
from network.platform.refusal import Spot, refuse


def check_parquet() -> None:
    """Raises Refused without pyarrow."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        right = "pip install 'lptn[parquet]', or leave it out for CSV"
        raise refuse(Spot("--parquet"), "needs pyarrow, which is not installed", right) from None


def write_parquet(path: Path, columns: Mapping[str, Array]) -> None:
    """Columns by their names with units, as double precision. The file is replaced as a whole."""
    import pyarrow
    from pyarrow import parquet

    table = pyarrow.table({name: np.ascontiguousarray(values) for name, values in columns.items()})
    replace_file(path, lambda beside: parquet.write_table(table, beside, compression="zstd"))


def write_run_columns(path: Path, t: Array, columns: Iterable[tuple[str, str, Array]]) -> None:
    """Columns of a run (name, unit, values in SI) over its time."""
    shown = {f"{name} [{unit_text}]": in_own_unit(values, unit_text) for name, unit_text, values in columns}
    write_parquet(path, {"time [s]": t} | shown)
