"""lptn: lumped-parameter thermal networks for machine tools.

from network import Machine, Scenario, Recording, simulate, compare
run = simulate(Machine.load("machines/gantry_spindle.yaml"), Scenario.load("scenarios/warm_up_and_stop.yaml"))
print(run)

The rooms, each of which uses itself and those above it in this list (tests/test_rooms.py):

platform     what every room stands on: refusals, results put into folders at once, processes, signals; units and
             numbers as text (quantities), YAML with the line of every value (yaml).
catalogue    the physics: one effect is one small file in mechanisms, expansions, sensors or suspects; declaration is
             the grammar that an entry is written in. A new effect is a new file here, and nothing else changes.
machine      a machine file read, checked over the whole, changed by patches, levels and `--set`.
recordings   what drives a machine and what was measured on it: scenarios, recordings, mappings, inputs over time.
engine       from a machine to a run: the network as arrays, the heat balance, solvers, trajectories; how channels
             answer to heat and parameters (response); what each heat source moves (superposition); the closed form of
             the heat-quantity method (paper).
analysis     what runs and recordings tell:
  comparison   residuals in units of noise, and tests of them;
  sweep        simplification levels and varied numbers;
  acceptance   the thermal tests of ISO 230-3, from simulations and recordings;
  correction   the machine reduced to the few states that a control steps, and the micrometres that this loses;
  calibration  uncertain numbers from recordings: parameters, noise, Gauss-Newton, multistart, uncertainty;
  drafting     a first machine from recordings alone: roles of columns, lag models, groups, parts, their sizes;
  diagnosis    missing physics: search is the loop, strategies what it looks for and how, settings its numbers;
               candidates (patches), hypotheses (their fits), lumps, screening, latent_heat (the honest rest), steps
               (forward selection, backward elimination, cross-validation), findings (invariants, verdict, what is
               told); apart: switching, intermittent, exchange, standstill; experiments that would tell more;
  change       then and now: numbers and sensors that differ between two sets of recordings.
report       results in words, pictures and files; the page of a diagnosis.
cli          the command `lptn`: parse, call, print; the demonstration and the proof.

The way of the data: Machine → Network → Plan → Trajectory → channels → residuals → Fit → Diagnosis → page. Each stage
is a frozen dataclass made from the one before by one function.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from network.platform.printing import use_printer

__version__ = "0.1.0"

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration as Calibration
    from network.analysis.calibration.calibrate import calibrate as calibrate
    from network.analysis.calibration.tcp_bands import bands_of as bands_of
    from network.analysis.change.changes import find_changes as find_changes
    from network.analysis.comparison.compare import Comparison as Comparison
    from network.analysis.comparison.compare import compare as compare
    from network.analysis.diagnosis.diagnose import diagnose as diagnose
    from network.analysis.diagnosis.findings.result import Diagnosis as Diagnosis
    from network.analysis.drafting.machine_draft import draft as draft
    from network.analysis.sweep.lump_choice import choose_lumps as choose_lumps
    from network.analysis.sweep.lumping_error import estimate_lumping as estimate_lumping
    from network.analysis.sweep.sample import sample as sample
    from network.analysis.sweep.sweep import Sweep as Sweep
    from network.analysis.sweep.sweep import sweep as sweep
    from network.engine.simulation import simulate as simulate
    from network.engine.superposition.superpose import superpose as superpose
    from network.engine.superposition.superposition import Superposition as Superposition
    from network.engine.trajectory import Trajectory as Trajectory
    from network.machine.machine import Machine as Machine
    from network.platform.refusal import Failed as Failed
    from network.platform.refusal import Refused as Refused
    from network.recordings.inputs import Start as Start
    from network.recordings.recording import Recording as Recording
    from network.recordings.scenario import Scenario as Scenario

_HOME = {
    "Machine": "machine.machine", "Scenario": "recordings.scenario", "Recording": "recordings.recording",
    "Start": "recordings.inputs",
    "simulate": "engine.simulation", "superpose": "engine.superposition.superpose",
    "compare": "analysis.comparison.compare",
    "calibrate": "analysis.calibration.calibrate", "sweep": "analysis.sweep.sweep",
    "sample": "analysis.sweep.sample",
    "estimate_lumping": "analysis.sweep.lumping_error", "choose_lumps": "analysis.sweep.lump_choice",
    "bands_of": "analysis.calibration.tcp_bands",
    "diagnose": "analysis.diagnosis.diagnose", "find_changes": "analysis.change.changes",
    "draft": "analysis.drafting.machine_draft",
    "Refused": "platform.refusal", "Failed": "platform.refusal",
    "Trajectory": "engine.trajectory", "Comparison": "analysis.comparison.compare", "Sweep": "analysis.sweep.sweep",
    "Calibration": "analysis.calibration.calibrate", "Diagnosis": "analysis.diagnosis.findings.result",
    "Superposition": "engine.superposition.superposition",
}  # fmt: skip
__all__ = [*_HOME, "__version__"]


def __getattr__(name: str) -> Any:
    """Names are fetched when first used, so that `lptn check` starts fast."""
    if name not in _HOME:
        raise AttributeError(f"network has no '{name}'; {_likely(name)}")
    return getattr(import_module(f"network.{_HOME[name]}"), name)


def _likely(name: str) -> str:
    from network.platform.refusal import likely

    return likely(name, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)


use_printer(lambda: import_module("network.report.show"))
