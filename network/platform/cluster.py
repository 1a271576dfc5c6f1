"""Work over the processes of a dask scheduler, which need lptn installed too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from network.platform.refusal import Spot, refuse

Item = TypeVar("Item")
Result = TypeVar("Result")
PATIENCE = "10 s"
"""How long a cluster may take to answer."""


def on_cluster(
    work: Callable[[Item], Result], items: Sequence[Item], address: str, tell: Callable[[float], None]
) -> list[Result]:
    """work(item) for every item. Raises Refused for a cluster that cannot be had."""
    spot = Spot(f"--cluster {address}")
    try:
        from distributed import Client
        from distributed import as_completed as as_finished
    except ImportError:
        right = "pip install 'lptn[cluster]', or use --jobs for processes on this machine"
        raise refuse(spot, "needs dask, which is not installed", right) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise refuse(spot, f"no scheduler answers there ({error})", "start one with `dask scheduler`") from None
    with client:
        everywhere = client.scatter(work, broadcast=True, hash=False)
        futures = [client.submit(_work_on, everywhere, item, pure=False) for item in items]
        try:
            for done, future in enumerate(as_finished(futures), 1):
                future.result()
                tell(done / len(futures))
            return [future.result() for future in futures]
        finally:
            client.cancel(futures)


def _work_on(work: Callable[[Item], Result], item: Item) -> Result:
    return work(item)
