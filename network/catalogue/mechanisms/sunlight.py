from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs

DAY = 86_400.0


class Sunlight(Source, kind="sunlight"):
    """The sun on one side, every day: q = P sin(π (t − rises)/lasts) while it shines, else 0; repeats after 24 h.

    t is the time of the run. Proposed where a recording lasts a day: a shorter one shows a hump that could be anything.
    P is absorptivity × lit area × irradiance at its peak: 0.5 m² of grey paint behind a pane
    takes some 100 W. Half a sine wave: no clouds, no shading within the day.
    """

    power = param("W", 0, 1e5, "heat at the day's peak", typical=100)
    rises = param("h", -24, 24, "time of the run at which the sun comes in", default=0, typical=6)
    lasts = param("h", 0, 24, "how long it shines", positive=True, default=12)
    follows_time = True
    least_run = DAY
    strength = "power"
    shapes = ("rises", "lasts")
    sentence = "the sun heats {into} with up to {power} for {lasts} a day"

    def heat(self, u: Inputs, *T: Array) -> Array:
        t = u["time"] - self.rises
        since = t - DAY * np.floor(np.real(t) / DAY)
        shines = np.real(since) < np.real(self.lasts)
        angle = np.pi * since / self.lasts
        return self.power * np.sin(angle, where=shines, out=np.zeros_like(angle))

    def edges(self, duration: float) -> Array:
        days = DAY * np.arange(-2, np.ceil(duration / DAY) + 1)
        starts = np.ravel(self.rises)[:, None] + days
        t = np.unique([starts, starts + np.ravel(self.lasts)[:, None]])
        return t[(t > 0) & (t < duration)]
