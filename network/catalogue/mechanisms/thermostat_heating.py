from __future__ import annotations

from network.catalogue.mechanisms.thermostat import Thermostat


class ThermostatHeating(Thermostat, kind="thermostat_heating"):
    """A heater with hysteresis: q = P while on; it goes on below set − h, off above set + h, `delay` later each time.

    The mirror of thermostat_cooling: a boiler, a heated bed, an oven. One mass C that loses q_loss < P and has no delay
    is on for t_on = 2hC/(P − q_loss) and off for t_off = 2hC/q_loss. It is on from the start where that is cold. Looked
    for where readings or what is missing tell its instants; it is not drawn, for a cooler of the same steps is.
    """

    sign, warmer, drawn = 1.0, 10.0, False
    sentence = "a heater gives {power} to {into}, on and off around {set} ± {hysteresis} at {watches}"
