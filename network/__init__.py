"""lptn: lumped-parameter thermal networks for machine tools.

from network import Machine, Scenario, Recording, simulate, compare
run = simulate(Machine.load("machines/gantry_spindle.yaml"), Scenario.load("scenarios/warm_up_and_stop.yaml"))
print(run)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from network.platform.printing import use_printer

__version__ = "0.1.0"

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import calibrate as calibrate
    from network.analysis.comparison.compare import compare as compare
    from network.analysis.diagnosis.diagnose import diagnose as diagnose
    from network.analysis.sweep.sweep import sweep as sweep
    from network.engine.simulation import simulate as simulate
    from network.machine.machine import Machine as Machine
    from network.platform.refusal import Failed as Failed
    from network.platform.refusal import Refused as Refused
    from network.recordings.recording import Recording as Recording
    from network.recordings.scenario import Scenario as Scenario

_HOME = {
    "Machine": "machine.machine", "Scenario": "recordings.scenario", "Recording": "recordings.recording",
    "simulate": "engine.simulation", "compare": "analysis.comparison.compare",
    "calibrate": "analysis.calibration.calibrate", "sweep": "analysis.sweep.sweep",
    "diagnose": "analysis.diagnosis.diagnose", "Refused": "platform.refusal", "Failed": "platform.refusal",
}  # fmt: skip
__all__ = [*_HOME, "__version__"]


def __getattr__(name: str) -> Any:
    """Names are fetched when first used, so that `lptn check` starts fast."""
    if name not in _HOME:
        raise AttributeError(f"network has no '{name}'")
    return getattr(import_module(f"network.{_HOME[name]}"), name)


use_printer(lambda: import_module("network.report.show"))
