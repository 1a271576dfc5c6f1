"""Stops of a driver in a run that no fit used, by its readings beside numbers that are known."""

from __future__ import annotations

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers
from network.analysis.calibration.gauss_newton import Linearised, linearise, make_problem
from network.analysis.calibration.measured_means import weigh_recording
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.standstill.driver import Driver
from network.analysis.diagnosis.standstill.standstill_edges import refine_edges
from network.analysis.diagnosis.standstill.standstill_scan import scan_stretches
from network.engine.response.parameters import at_values, values_at
from network.recordings.recording import Recording

MOST = 3
"""Stops of a run that are looked for (budget)."""


def find_held_out_stops(numbers: Numbers, recording: Recording, driver: Driver) -> Windows:
    """The stops that explain more than chance at full strength, the machine's numbers as they are, each channel
    counting by how far it is off in the runs that these come from."""
    machine = at_values(numbers.original, values_at(numbers.parameters, numbers.theta))

    def about(stops: tuple[Windows, ...]) -> Linearised:
        stopped = driver.stop(machine, recording, stops[0])
        return linearise(make_problem(machine, (), [weigh_recording(machine, stopped, numbers.start)]), np.empty(0))

    stops: Windows = ()
    for _ in range(MOST):
        found = scan_stretches(about((stops,)), [driver], misfits=numbers.misfit)
        best = next((s for s in found if s.is_full), None)
        if best is None or best.gain <= SETTINGS.least + np.log(best.tried):
            break
        stops = tuple(sorted((*stops, (best.begin, best.end))))
    return refine_edges(about, (stops,)).stops[0] if stops else stops
