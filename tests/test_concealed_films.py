"""Films and friction by correlation, concealed: a machine with one makes recordings, its file does without it. Those
that are proposed explain them as proposed; those whose input or oil only the user knows, once they are written down."""

from __future__ import annotations

from typing import Any

import pytest
from fits import two_blocks
from test_concealed_kinds import MORE, conceal, explain, levels, own, proposed, said

from network import Machine
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis

TURNS = {"motor": {"heat_capacity": "4 kJ/K ± 20 %", "rotates": "true"}}
FEED = levels("feed", "m/min", 0, 20, 5, 40, 0, 30, 10, 0)
FLOW = levels("flow", "l/min", 1, 8, 0, 15, 4, 0, 10, 2)


@pytest.mark.parametrize(
    ("section", "kind", "places", "body", "numbers"),
    [
        ("links", "rotating_cylinder", ("motor", "air"),
         {"between": ["motor", "air"], "diameter": "80 mm", "area": "0.06 m^2"}, {"area": 0.06}),
        ("links", "rotating_disc", ("motor", "air"),
         {"between": ["motor", "air"], "diameter": "250 mm", "area": "0.1 m^2"}, {"area": 0.1}),
        ("sources", "palmgren_friction", ("motor",),
         {"into": {"motor": 1}, "lubrication_factor": 1.2, "oil": {"grade": 32}, "mean_diameter": "80 mm"},
         {"lubrication_factor": 1.2}),
    ],
)  # fmt: skip
def test_what_turns_is_explained_as_it_is_proposed(
    section: str, kind: str, places: tuple[str, ...], body: dict[str, Any], numbers: dict[str, float]
) -> None:
    plain = two_blocks(nodes=TURNS)
    case = conceal(plain, plain.patched({section: {"it": {"kind": kind, **body}}}))
    found = explain(case, proposed(case, section, kind, *places))
    assert own(found) == pytest.approx(numbers, rel=0.1)
    assert len(said(found)) > 20


def test_a_gap_that_stirs_its_air() -> None:
    """Beside a flange that its file knows: it is told by what the speed does to it."""
    plain = two_blocks(nodes=TURNS)
    sizes = {"area": "0.08 m^2", "diameter": "100 mm", "gap": "0.5 mm"}
    gap = {"kind": "annular_gap", "between": ["motor", "body"], **sizes}
    case = conceal(plain, plain.patched({"links": {"gap": gap}}))
    known = fit_hypothesis(case, with_link(plain, {**gap, "area": "0.02 m^2 ± 300 %"}))
    assert fit_hypothesis(case, plain).chi > 1.1 > 1.05 > known.chi
    assert known.values["links.it.area"] == pytest.approx(0.08, rel=0.2)


def with_link(plain: Machine, body: dict[str, Any]) -> Machine:
    return plain.patched({"links": {"it": body}})


@pytest.mark.parametrize(
    "film",
    [
        {"kind": "plate_flow", "between": ["body", "air"], "length": "0.4 m", "moves": "feed"},
        {"kind": "pipe_flow", "between": ["body", "air"], "diameter": "12 mm", "length": "2 m", "input": "flow",
         "fluid": "oil_vg_32"},
    ],
    ids=lambda film: film["kind"],
)  # fmt: skip
def test_a_film_that_an_input_moves(film: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    for signal in (FEED, FLOW):
        monkeypatch.setitem(MORE, signal.name, signal)  # type: ignore[arg-type]
    plain = two_blocks()
    area = {"plate_flow": 1.2, "pipe_flow": 0.4}[film["kind"]]
    case = conceal(plain, with_link(plain, {**film, "area": f"{area} m^2"}))
    known = fit_hypothesis(case, with_link(plain, {**film, "area": "0.1 m^2 ± 300 %"}))
    assert fit_hypothesis(case, plain).chi > 1.3 > 1.1 > known.chi
    assert known.values["links.it.area"] == pytest.approx(area, rel=0.1)


def test_a_bearing_whose_oil_thins() -> None:
    rubs = {"kind": "bearing_friction", "into": {"motor": 0.5, "body": 0.5}, "torque": "0.5 N m ± 40 %"}
    plain = two_blocks(sources={"rub": rubs})
    oiled = {"kind": "viscous_friction", "into": rubs["into"], "oil": {"grade": 46}, "reads": "motor"}
    case = conceal(plain, plain.patched({"sources": {"rub": {**oiled, "torque": "0.6 N m"}}}))
    known = fit_hypothesis(case, plain.patched({"sources": {"rub": {**oiled, "torque": "0.5 N m ± 40 %"}}}))
    assert fit_hypothesis(case, plain).chi > 1.3 > 1.1 > known.chi
    assert known.values["sources.rub.torque"] == pytest.approx(0.6, rel=0.1)


def test_a_wall_by_its_shape_and_orientation() -> None:
    film = {"kind": "convection", "between": ["body", "air"]}
    plain = two_blocks(links={"skin": {**film, "conductance": "7 W/K ± 30 %"}})
    wall = {**film, "geometry": "plate", "orientation": "up", "length": "0.2 m"}
    case = conceal(plain, plain.patched({"links": {"skin": {**wall, "area": "2.5 m^2"}}}))
    known = fit_hypothesis(case, plain.patched({"links": {"skin": {**wall, "area": "1.5 m^2 ± 50 %"}}}))
    assert fit_hypothesis(case, plain).chi > known.chi + 0.02 and known.chi < 1.05
    assert known.values["links.skin.area"] == pytest.approx(2.5, rel=0.1)
