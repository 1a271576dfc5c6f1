from __future__ import annotations

from network.catalogue.mechanisms.thermostat import Thermostat


class ThermostatCooling(Thermostat, kind="thermostat_cooling"):
    """A cooler with hysteresis: q = −P while on; it goes on above set + h, off below set − h, `delay` later each time.

    For one mass C with constant heat q < P, no losses and no delay it is on for t_on = 2hC/(P − q) and off for
    t_off = 2hC/q: the period 2hC P/(q (P − q)) is shortest at q = P/2, so it falls as the load rises up to half the
    cooling power. A delay d lets the temperature overshoot by q d/C above and (P − q) d/C below. Proposed with its set
    point at the reference: off until the part is the half width warmer.
    """

    changed = {"power": ("a cooler that grew stronger", "a cooler that weakened: its filter, its fan or its fluid")}
    sign, warmer = -1.0, 0.0
    sentence = "a cooler takes {power} out of {into}, on and off around {set} ± {hysteresis} at {watches}"
