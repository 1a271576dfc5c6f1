"""Stretching, bending and tilt on whole machines, against hand calculations."""

from __future__ import annotations

import numpy as np
import pytest
from build import machine, schedule

from network import simulate
from network.engine.assembly import build
from network.engine.channels import readouts
from network.recordings.inputs import Start

ALPHA, H, L = 1.13e-5, 0.4, 2.0


def bent(lumps: int, rise: np.ndarray) -> float:
    """Displacement of a steel table whose axis is its height, for a given profile of rises."""
    built = machine(
        {"table": {"material": "steel", "length": f"{H} m", "area": "0.5 m^2", "lumps": lumps}},
        sources={"none": {"kind": "heat_source", "into": {"table": 1}, "power": "0 W"}},
        tcp={"z": {"bends": {"kind": "bending", "of": "table", "length": f"{L} m", "direction": 1}}},
    )
    outputs = readouts(build(built))
    row, _ = outputs.where["reading", "z", "bends", "0"]
    return float(built.tcp["z"]["bends"].movement({"time": np.zeros(())}, np.array(outputs.rows[row] @ rise)))


@pytest.mark.parametrize("lumps", [2, 5, 20])
def test_linear_profile_bends_exactly(lumps: int) -> None:
    """θ = α ΔT L/(2H) for ΔT between the faces, ΔH = L/2 tan(θ/2), whatever the number of lumps."""
    y = (np.arange(lumps) + 0.5) / lumps
    theta = ALPHA * 10 * L / (2 * H)
    assert bent(lumps, 10 * y) == pytest.approx(L / 2 * np.tan(theta / 2), rel=1e-12)


def test_curvature_follows_the_first_moment() -> None:
    """A skin of a tenth of the depth: 12/H³ ∫ΔT y dy = 12 · 0.1 · 0.45 = 0.54 ΔT/H; the faces would say 1."""
    rise = np.zeros(200)
    rise[180:] = 10.0
    theta = ALPHA * 0.54 * 10 / H * L / 2
    assert bent(200, rise) == pytest.approx(L / 2 * np.tan(theta / 2), rel=1e-4)


def test_cold_top_bends_the_other_way() -> None:
    assert bent(10, -np.linspace(0, 5, 10)) == pytest.approx(-bent(10, np.linspace(0, 5, 10)), rel=1e-12)


def test_bending_by_the_papers_equation() -> None:
    """Eq. 9: ΔH = (L/2)(1 − cos θ)/sin θ with θ = α E/(ρ c S H), E the heat absorbed above the reference."""
    heated = machine(
        {"table": {"material": "steel", "length": f"{H} m", "area": "0.5 m^2", "lumps": 10}},
        sources={"cutting": {"kind": "heat_source", "into": {"table@1": 1}, "power": "300 W"}},
        tcp={"z": {"bends": {"kind": "bending", "of": "table", "length": f"{L} m", "direction": 1, "method": "paper"}}},
    )
    run = simulate(heated, schedule(np.arange(0, 7201, 600.0)))
    # stretching of the heated face over the table's length: ΔL = α L E/(ρ c S H)
    theta = ALPHA * L * 300 * 7200 / (7850 * 477 * 0.5 * H) / H
    assert run.tcp["z"][-1] == pytest.approx(L / 2 * (1 - np.cos(theta)) / np.sin(theta), rel=1e-9)


def test_start_above_the_reference_counts() -> None:
    """A machine that starts 5 K warm is already 5 K α L long; a probe zeroed at the start reads nothing of it."""
    warm = machine(
        {"bar": {"material": "aluminium", "length": "500 mm", "area": "20 cm^2"}},
        sources={"none": {"kind": "heat_source", "into": {"bar": 1}, "power": "0 W"}},
        tcp={
            "z": {m: {"kind": "stretching", "of": "bar", "direction": -1, "method": m} for m in ("temperature", "heat")}
        },
        sensors={
            "dz": {"measures": "tcp.z", "noise": "1 um"},
            "probe": {"measures": "tcp.z", "noise": "1 um", "zero": "start"},
        },
    )
    run = simulate(warm, schedule([0, 60.0], start=Start(others=25.0)))
    for method in ("temperature", "heat"):
        assert run.contributions["z", method] == pytest.approx(-2.34e-5 * 0.5 * 5, rel=1e-9)
    assert run.sensors["probe"] == pytest.approx(0.0, abs=1e-18)
    assert run.shown("dz")[-1] == pytest.approx(-2 * 58.5, rel=1e-9)


def test_tilt_moves_by_the_lever() -> None:
    """Two columns 0.3 m apart, 0.5 m long, 4 K apart in temperature, seen at the end of a 0.4 m arm; the angle on b."""
    columns = {n: {"material": "cast_iron", "length": "500 mm", "area": "100 cm^2"} for n in ("left", "right")}
    tilt = {"kind": "tilt", "between": ["left", "right"], "distance": "300 mm", "direction": 1}
    built = machine(
        columns,
        sources={n: {"kind": "heat_source", "into": {n: 1}, "power": "0 W"} for n in columns},
        tcp={"z": {"lean": tilt | {"arm": "400 mm"}}, "b": {"lean": tilt}},
    )
    run = simulate(built, schedule([0, 1.0], start=Start(nodes={"left": 26, "right": 22})))
    angle = 1.08e-5 * 0.5 * 4 / 0.3
    assert run.tcp["b"][0] == pytest.approx(angle, rel=1e-9)
    assert run.tcp["z"][0] == pytest.approx(0.4 * angle, rel=1e-9)
