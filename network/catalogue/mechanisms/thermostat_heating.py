from __future__ import annotations

from network.catalogue.mechanisms.thermostat import Thermostat


class ThermostatHeating(Thermostat, kind="thermostat_heating"):
    """A heater with hysteresis: q = P while on; it goes on below set − h, off above set + h, `delay` later each time.

    The mirror of thermostat_cooling: a boiler, a heated bed, an oven. One mass C that loses q_loss < P and has no delay
    is on for t_on = 2hC/(P − q_loss) and off for t_off = 2hC/q_loss. It is on from the start where that is cold. Not
    looked for beside thermostat_cooling: where it switches must be searched for at every part, at all set points.
    """

    sign, warmer = 1.0, 10.0
    sentence = "a heater gives {power} to {into}, on and off around {set} ± {hysteresis} at {watches}"
    searched = False
