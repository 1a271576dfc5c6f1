"""Single decisions of the solvers on bare numbers: what mutation testing found no quick test to look at."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from build import machine, schedule
from test_small_decisions import bare

from network import simulate
from network.analysis.calibration import coloured_noise
from network.analysis.calibration.identifiability_report import relative
from network.engine.solvers import rosenbrock
from network.engine.solvers.crossing import _bound_guards
from network.engine.solvers.ramps import BENDS, MOST_PIECES, straighten_ramps
from network.engine.solvers.relay_modes import FEWEST, LONGEST, RelayModes


def squares(follows_time: bool = False) -> Any:
    """Heats of the square of a speed, as an entry group tells them."""
    law = bare(follows_time=follows_time, needs=lambda: ("speed",))
    return bare(law=law, reads=(), heat=lambda u: u["speed"] ** 2)


def cut(first: list[float], last: list[float], *signals: Any) -> Any:
    network, n = bare(heats=(squares(),), relays=()), len(first)
    edges = 100.0 * np.arange(n + 1)
    left, right = ({"speed": np.array(v), "time": t} for v, t in ((first, edges[:-1]), (last, edges[1:])))
    return straighten_ramps(network, bare(signals=dict(enumerate(signals))), edges, left, right)


def test_ramps_are_cut_so_finely_that_a_square_is_straight() -> None:
    """(1 + a s)² is a²/4 off its chord in the middle; cut into n pieces, n² times less."""
    a = 1e-3
    n = int(np.ceil(np.sqrt((a / 2) ** 2 / (1 + a) ** 2 / BENDS)))
    assert n == 16
    np.testing.assert_allclose(cut([1.0, 1 + a], [1 + a, 1 + a]), [*np.linspace(0, 100, n + 1), 200])
    assert cut([1.0, 2.0], [1.0, 2.0]).tolist() == [0.0, 100.0, 200.0]
    assert len(cut([0.0], [9.0])) == MOST_PIECES + 1
    axis = bare(span=lambda start, end: (np.array([-1.0, 5.0]), np.array([3.0, 5.0])))
    crossed = cut([1.0, 1 + 2e-4], [1 + 2e-4, 1.0], axis)
    np.testing.assert_allclose(crossed, sorted({*np.linspace(0, 200, 9), 25.0}))


def test_a_guard_rises_for_sure_once_where_it_rises_by_more_than_it_may_bend() -> None:
    values, bend = np.array([[-1.0, -1.0, -1.0, 0.99], [1.0, -0.01, -0.02, 1.0]]), np.array([[0.1, 0.1, 0.1, 0.1]])
    may, once = _bound_guards(values, bend)
    assert may.tolist() == [[True, True, False, True]] and once.tolist() == [[True, False, False, False]]


@pytest.mark.parametrize("pieces, h", [(FEWEST, 0.1), (FEWEST, LONGEST * FEWEST), (10, 9.5 * LONGEST)])
def test_relays_are_looked_at_as_often_as_a_step_is_long(pieces: int, h: float) -> None:
    looked = list[int]()

    def values_at(seen: Any, s: Any) -> Any:
        looked.append(len(s) - 1)
        return -np.ones((1, len(s))).T

    assert RelayModes.first_crossing(bare(_values=values_at), bare(), h) is None  # type: ignore[arg-type]
    assert looked == [pieces]


def test_a_step_is_followed_by_one_that_would_err_as_much_as_is_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.9 of it, as errors grow with the fourth power of a step: by a factor of five at most, a fifth at least."""
    for size, factor in ((0.5, 0.9 * 0.5**-0.25), (1.0, 0.9), (1e-9, 5.0), (0.0, 5.0)):
        made = (np.zeros(1), None, np.array([size]))
        monkeypatch.setattr(rosenbrock.rodas, "step", lambda *of, made=made: made)
        kept = list[Any]()
        solver = bare(
            _rate=lambda t, x: np.zeros(1), _slopes=lambda t, x: None, _stop_at_crossing=lambda *of: None, mass=None,
            layout=None, frozen=None, heat=bare(is_steady=True), tolerance=1.0,
            relays=bare(on=None),
            steps=bare(keep=lambda *of, kept=kept: kept.append(of)),
        )  # fmt: skip
        _, now, following, took = rosenbrock._Run._step_anew(solver, 0, 10.0, np.zeros(1), 2.0, 100.0, np.zeros(1))
        assert (now, took) == (12.0, 2.0) and following == pytest.approx(2.0 * factor) and len(kept) == 1


def test_a_lagging_sensor_reads_the_same_by_steps_as_by_modes() -> None:
    skin = {"kind": "convection", "between": ["a", "air"], "conductance": "2 W/K"}
    of = machine(
        {"a": {"heat_capacity": "1 kJ/K"}, "air": {"temperature": "20 degC"}}, links={"skin": skin},
        sources={"heater": {"kind": "heat_source", "into": {"a": 1}, "power": "100 W"}},
        sensors={"T": {"measures": "a", "noise": "0.1 K", "effects": [{"kind": "sensor_lag", "lag": "200 s"}]}},
    )  # fmt: skip
    runs = [simulate(of, schedule(np.arange(0.0, 3600, 60)), method=method) for method in ("modal", "rosenbrock")]
    np.testing.assert_allclose(runs[0].sensors["T"], runs[1].sensors["T"], atol=1e-4)
    rise = runs[0].sensors["T"] - 20
    t, tau, lag = runs[0].t, 500.0, 200.0
    np.testing.assert_allclose(
        rise, 50 * (1 - (tau * np.exp(-t / tau) - lag * np.exp(-t / lag)) / (tau - lag)), atol=1e-6
    )


def test_sensors_of_a_kind_share_the_time_that_leaves_least_squares(monkeypatch: pytest.MonkeyPatch) -> None:
    """One is better by 2 with the one time and the other by 1 with the other, from where it counts more."""
    left = {"a": [3.0, 2.0], "b": [0.0, 2.0], "w": [0.0, 9.0], "z": [9.0, 1.0]}
    monkeypatch.setattr(coloured_noise, "TIMES", (10.0, 30.0))
    monkeypatch.setattr(coloured_noise, "_structures", lambda own: own)
    monkeypatch.setattr(coloured_noise, "colour", lambda own, interval: (0.1, 0.0 if own == "w" else 0.1, 9.0))
    monkeypatch.setattr(coloured_noise, "_part", lambda own, tau: (left[own][(10.0, 30.0).index(tau)], None))
    units = dict.fromkeys("abw", "degC") | {"z": "um"}
    told = coloured_noise._pool_times({name: name for name in left}, units)  # type: ignore[misc]
    assert told == {"a": (30.0,), "b": (30.0,), "w": (30.0,), "z": (30.0,)}
    units["z"] = "degC"
    left["z"] = [0.0, 2.0]
    assert coloured_noise._pool_times({name: name for name in left}, units)["a"] == (10.0,)  # type: ignore[misc]


@pytest.mark.parametrize(
    "unit, is_log, told",
    [("degC", False, "0.123 K"), ("W/K", False, "0.123 W/K"), ("1", False, "0.123"), ("W/K", True, "12.3 %")],
)
def test_a_standard_error_is_told_in_the_unit_of_a_difference(unit: str, is_log: bool, told: str) -> None:
    assert relative(bare(is_log=is_log, field=bare(unit=unit)), 1.0, 0.1234) == told
