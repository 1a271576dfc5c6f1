"""Where simulation and recordings differ, told at the numbers that stand beside the heat that explains most."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from test_latent_rest import BURSTS, fitted

from network.analysis.calibration.gauss_newton import linearise
from network.analysis.diagnosis.latent_heat import latent_rest
from network.analysis.diagnosis.latent_heat.latent_rest import find_rest, find_rest_at
from network.analysis.diagnosis.latent_heat.locate import explain_unknown, locate, trace
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.mismatch import locate_mismatch
from network.platform.refusal import Failed

Values = np.ndarray[Any, Any]


def burst_heat(t: Values) -> Values:
    """W at the column."""
    heat = np.zeros(len(t))
    for source in BURSTS.values():
        duration, phase = (60.0 * float(str(source[word]).split()[0]) for word in ("duration", "phase"))
        heat[(t >= phase) & (t < phase + duration)] += 150.0
    return heat


def likeness(told: UnknownHeat) -> float:
    """Of a told course and the real one, over all runs."""
    pairs = [np.stack([heat, burst_heat(t)]) for t, heat in zip(told.t, told.heat, strict=True)]
    return float(np.corrcoef(np.concatenate(pairs, axis=1))[0, 1])


def test_the_course_is_told_beside_the_numbers_that_it_leaves() -> None:
    """A fit without the bursts bends its numbers to them, and seen from there they are another heat."""
    null = fitted("bursts", ())
    mismatch = locate_mismatch(null)
    top = mismatch.places[0]
    assert str(top.at) == "column" and np.abs(mismatch.about.fit.theta - null.fit.theta).max() > 0.01
    told, before = mismatch.trace(top), trace(null.linearised, top, float(np.mean(null.fit.left**2)))
    assert likeness(told) > max(0.8, likeness(before))
    assert told.rms == pytest.approx(np.sqrt(np.mean(np.concatenate(told.heat) ** 2)))


def test_a_place_that_explains_less_is_told_less_surely() -> None:
    """As much counts as noise as is left beside heat there."""
    mismatch = locate_mismatch(fitted("bursts", ()))
    top, other = mismatch.places[0], next(u for u in mismatch.places if str(u.at) == "spindle")
    left = [find_rest_at(mismatch.about, u).left for u in (top, other)]
    assert left[1] > 1.5 * left[0]
    surely = [float(np.mean(trace(mismatch.about.linearised, other, scale).std[0])) for scale in left]
    assert float(np.mean(mismatch.trace(other).std[0])) == pytest.approx(surely[1]) and surely[1] > surely[0]


def test_once_it_is_late_the_course_alone_is_told_beside_it() -> None:
    """Places are compared once, as the numbers of the fit have them."""
    null = fitted("bursts", ())
    late, own = locate_mismatch(null, lambda: True), locate(null.linearised, null.machine)
    times = iter([False, True])
    midway = locate_mismatch(null, lambda: next(times))
    assert [u.at for u in midway.places] == [u.at for u in late.places]
    assert [u.at for u in late.places] == [u.at for u in own]
    assert [u.gain for u in late.places] == pytest.approx([u.gain for u in own])
    before = trace(null.linearised, own[0], float(np.mean(null.fit.left**2)))
    assert likeness(late.trace(late.places[0])) > max(0.8, likeness(before))


def test_beside_the_heat_that_is_missing_nothing_but_noise_is_left() -> None:
    null, named = fitted("pump", ()), fitted("pump", (("heat_source", "column"),))
    before, mismatch = find_rest(null), locate_mismatch(null)
    left = find_rest_at(mismatch.about, mismatch.places[0]).left
    assert left == pytest.approx(max(1.0, float(np.mean(named.fit.left**2))), abs=0.15)
    assert before.left > left  # priors of starts are as narrow as without the heat


def test_what_nothing_is_missing_from_is_told_at_its_own_numbers() -> None:
    named = fitted("pump", (("heat_source", "column"),))
    assert locate_mismatch(named).about.fit is named.fit


def test_heat_through_a_link_is_what_one_part_gives_and_the_other_takes() -> None:
    null = fitted("bursts", ())
    links = [u for u in locate(null.linearised, null.machine, 1.0) if u.at.kind == "link"]
    assert links
    for told in links:
        alone = explain_unknown(null.linearised, told)
        assert told.gain == pytest.approx(alone.gain, rel=1e-9)
        np.testing.assert_allclose(np.concatenate(told.heat), np.concatenate(alone.heat), rtol=1e-6, atol=1e-9)


def moves(monkeypatch: pytest.MonkeyPatch, breaks: Iterable[int]) -> tuple[float, list[float]]:
    """What the first move adds, and the shares of its step that were tried where some of these tries break down."""
    first, tried = find_rest(fitted("bursts", ()), refit=False), list[float]()
    start = first.beside.linearised

    def follow(problem: Any, theta: Values) -> Any:
        tried.append(float(np.linalg.norm(theta - start.theta)))
        if len(tried) in breaks:
            raise Failed("it runs away")
        return linearise(problem, theta)

    monkeypatch.setattr(latent_rest, "linearise", follow)
    moved = first.move_numbers()
    return (moved.evidence - first.evidence if moved else -np.inf), tried


def test_a_step_that_leads_too_far_is_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    gain, tried = moves(monkeypatch, ())
    assert gain > 0 and len(tried) == 1
    gain, tried = moves(monkeypatch, (1, 2))
    assert gain > 0 and tried[1:] == pytest.approx([0.5 * tried[0], 0.25 * tried[0]], rel=0.3)
    gain, tried = moves(monkeypatch, (1, 2, 3))
    assert gain == -np.inf and len(tried) == 3
