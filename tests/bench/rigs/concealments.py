"""What is hidden from the diagnosis on the real rigs, one thing at a time, and the right answer."""

from __future__ import annotations

from collections.abc import Callable

from bench.rigs.answers import Answer
from bench.rigs.case import Concealment, Tree, load_table
from bench.rigs.hiding import (
    another_column,
    both,
    constant,
    entries,
    first_path,
    heated,
    no_column,
    of_the_feed,
    stop,
    swapped,
    without,
    without_stop,
)
from bench.rigs.splits import RECORDINGS

HEAT = frozenset({"heat_source", "timed_source"})
FRICTION = frozenset({"guide_friction", "screw_friction"})
LINKS = frozenset({"conduction", "contact", "convection", "natural_convection", "forced_convection", "radiation"})
EXPANSIONS = frozenset({"stretching", "bending", "tilt", "centrifugal_growth", "post"})
MASSES = frozenset({"hidden_mass", "interposed_mass"})
SENSORS = frozenset({"sensor_fault", "sensor_offset", "sensor_swap", "sensor_crosstalk"})
FOLLOWS = 0.7
STEADY_PUMP = {"kind": "conduction", "between": ["radiators", "return pipe"], "conductance": "1 kW/K ± 80 %"}
"""The building's without what says when it runs."""


def always(answer: Answer) -> Callable[[Tree], Answer]:
    return lambda tree: answer


def at(*places: str) -> frozenset[str]:
    return frozenset(places)


def sources(*names: str) -> Callable[[Tree], tuple[str, ...]]:
    return lambda tree: names


def feed_heat(tree: Tree) -> Answer:
    parts = heated(tree, of_the_feed(tree))
    words = "heat while it runs, or with the feed, at a part that follows the feed"
    return Answer(words, HEAT | FRICTION, parts, alike=HEAT, drivers=at("running", "feed", "speed"))


def room(tree: Tree) -> Answer:
    held = at(*(name for name, node in tree["nodes"].items() if node and node.get("temperature") == "ambient"))
    return Answer("a room that drifts", at("ambient_drift"), held)


def the_stop(tree: Tree) -> Answer:
    """When the machine stood: from the recording itself."""
    table = load_table(RECORDINGS / "cnc-lathe" / "run_20200810.csv")
    found, time = stop(table, "speed_rpm"), table[0].index("time_min")
    assert found is not None
    begin, end = (60 * float(table[i][time]) for i in found)
    return Answer(f"something from {begin / 60:.0f} to {end / 60:.0f} min", frozenset(), window=(begin, end))


def grown(tree: Tree) -> Answer:
    return Answer("an expansion along z", EXPANSIONS, at("tcp.z"))


CONCEALMENTS = (
    Concealment(
        "Q2", "two-heaters", "Q2 and its source",
        always(Answer("heat at heater 2 in Q2's course", HEAT, at("heater 2"), alike=HEAT, follows=FOLLOWS)),
        without("sources", "heating 2"), no_column("Q2"), heat=sources("heating 2"),
    ),
    Concealment(
        "heaters-apart", "two-heaters", "both links between the heaters",
        always(Answer("a link between the heaters", LINKS, at("heater 1", "heater 2"), every=True)),
        without("links", "film between", "glow between"),
    ),
    Concealment(
        "swap", "two-heaters", "which of T1 and T2 is which",
        always(Answer("T1 and T2 swapped", at("sensor_swap"), channels=at("T1", "T2"), alike=SENSORS)),
        mapping=swapped("T1", "T2"),
    ),
    Concealment(
        "P-heating", "building", "P_heating and its source",
        always(Answer("heat at the radiators in P_heating's course", HEAT, at("radiators"), alike=HEAT,
                      follows=FOLLOWS)),
        both(without("sources", "heating"), entries("links", pump=STEADY_PUMP)), no_column("P_heating"),
        heat=sources("heating"),
    ),
    Concealment(
        "P-heating-source", "building", "the source of P_heating, which is recorded",
        always(Answer("heat at the radiators with P_heating", HEAT, at("radiators"), alike=HEAT,
                      drivers=at("P_heating"))),
        without("sources", "heating"), heat=sources("heating"),
    ),
    Concealment(
        "outdoor", "building", "the course of outdoor",
        always(Answer("outdoor drifts", at("ambient_drift"), at("outdoor"))),
        mapping=constant("outdoor", "degC"),
    ),
    Concealment(
        "elements", "oven", "the mass of the elements",
        always(Answer("a mass between heating and air", MASSES, at("elements", "heating", "air"),
                      alike=at("sensor_lag"))),
        entries("nodes", elements={}),
    ),
    Concealment(
        "bed-frame", "gantry-13", "the link from bed to frame",
        always(Answer("a link from bed to frame", LINKS, at("bed", "frame"), every=True)),
        without("links", "bed to frame"),
    ),
    Concealment(
        "NTC7", "three-blocks", "that NTC7 is not on the cylinder it is listed for",
        always(Answer("NTC7 is not to be believed", SENSORS, channels=at("NTC7"))),
        lambda tree: {"sensors": {"NTC7": {**tree["sensors"]["NTC8"]}}}, another_column("NTC7_C", "NTC7 [degC]"),
    ),
    Concealment(
        "feed-heat", "cnc", "the heat of the feed", feed_heat,
        lambda tree: without("sources", *of_the_feed(tree))(tree), heat=of_the_feed,
    ),
    Concealment("room", "cnc", "the course of the room", room, mapping=constant("ambient", "degC")),
    Concealment(
        "stop", "cnc", "the stop of 10 August", the_stop,
        rows=without_stop("speed_rpm", "speed_rpm", "feed_m_min"),
    ),
    Concealment(
        "expansion", "cnc", "the first expansion along z", grown,
        lambda tree: {"tcp": {"z": {first_path(tree, "z"): None}}},
    ),
)  # fmt: skip
