"""lptn: lumped-parameter thermal networks for machine tools.

from network import Machine, Scenario, Recording, simulate, compare
run = simulate(Machine.load("machines/gantry_spindle.yaml"), Scenario.load("scenarios/warm_up_and_stop.yaml"))
print(run)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from network.calibration.calibrating import calibrate as calibrate
    from network.comparison import compare as compare
    from network.diagnosis.diagnosing import diagnose as diagnose
    from network.machine import Machine as Machine
    from network.recording import Recording as Recording
    from network.refusal import Failed as Failed
    from network.refusal import Refused as Refused
    from network.scenario import Scenario as Scenario
    from network.simulation import simulate as simulate
    from network.sweeping import sweep as sweep

_HOME = {
    "Machine": "machine", "Scenario": "scenario", "Recording": "recording", "simulate": "simulation",
    "compare": "comparison", "calibrate": "calibration.calibrating", "sweep": "sweeping",
    "diagnose": "diagnosis.diagnosing",
    "Refused": "refusal", "Failed": "refusal",
}  # fmt: skip
__all__ = [*_HOME, "__version__"]


def __getattr__(name: str) -> Any:
    """Names are fetched when first used, so that `lptn check` starts fast."""
    if name not in _HOME:
        raise AttributeError(f"network has no '{name}'")
    return getattr(import_module(f"network.{_HOME[name]}"), name)
