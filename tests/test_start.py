"""Where a run begins, by the rules of scenarios and recordings."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from build import machine, schedule

from network import Failed, Recording, Refused, compare, simulate
from network.analysis.comparison.common_start import doubt_starts, share_start_rule
from network.recordings.inputs import Start
from network.recordings.recording import Column
from network.recordings.yaml_values import start_of


def chain():
    """hot – a – junction – b – cold: what is not sensed lies between."""
    return machine(
        {
            "hot": {"temperature": "40 degC"}, "a": {"heat_capacity": "1 kJ/K"}, "junction": {},
            "b": {"heat_capacity": "1 kJ/K"}, "cold": {"temperature": "10 degC"},
        },
        links={
            "1": {"kind": "conduction", "between": ["hot", "a"], "conductance": "2 W/K"},
            "2": {"kind": "conduction", "between": ["a", "junction"], "conductance": "4 W/K"},
            "3": {"kind": "conduction", "between": ["junction", "b"], "conductance": "4 W/K"},
            "4": {"kind": "conduction", "between": ["b", "cold"], "conductance": "2 W/K"},
        },
        sensors={"A": {"measures": "a", "noise": "0.1 K"}},
    )  # fmt: skip


def recorded(readings: list[float]) -> Recording:
    t = np.arange(len(readings)) * 20.0
    return Recording("r", "r.csv", t, {"A": Column("A", "degC", np.array(readings))})


def begins(source, **words) -> dict[str, float]:
    return {name: float(T[0]) for name, T in simulate(chain(), source, **words).parts.items()}


def test_first_readings_near_the_reference_mean_a_cold_start() -> None:
    assert begins(recorded([20.3, 20.4, 19.8, 20.1]))["b"] == pytest.approx(20.0)


def test_a_part_that_warms_within_the_first_minute_still_started_cold() -> None:
    assert begins(recorded([20.1, 21.5, 23.0, 24.4, 25.0]))["a"] == pytest.approx(20.0)


def test_else_sensed_parts_start_at_their_first_minute_and_others_in_between() -> None:
    """a at the mean of its first minute, 28; b between 28 over 2 W/K and 10 over 2 W/K: 19."""
    start = begins(recorded([28.5, 27.5, 28.3, 27.7, 10.0]))
    assert start["a"] == pytest.approx(28.0)
    assert start["b"] == pytest.approx(19.0, abs=1e-6)


def test_a_part_that_moves_in_its_first_minute_starts_where_its_line_does() -> None:
    """A rise of 6 K in the minute, 20 °C at its beginning; the mean would be 31 °C."""
    t = np.arange(0.0, 61.0, 5.0)
    warm = Recording("r", "r.csv", t, {"A": Column("A", "degC", 28.0 + 0.1 * t)})
    assert begins(warm)["a"] == pytest.approx(28.0, abs=0.01)


def test_runs_of_one_call_begin_by_one_rule() -> None:
    cold, warm = recorded([20.2, 20.2, 20.2, 20.2]), recorded([28.0, 28.1, 27.9, 28.0])
    assert compare(chain(), [cold]).recordings[0].trajectory.sensors["A"][0] == pytest.approx(20.0, abs=1e-9)
    assert compare(chain(), [cold, warm]).recordings[0].trajectory.sensors["A"][0] == pytest.approx(20.2)
    assert begins(share_start_rule(chain(), [cold, warm])[0])["b"] == pytest.approx(15.1, abs=1e-6)


def test_runs_of_a_calibrated_machine_begin_by_the_rule_of_those_it_was_calibrated_on() -> None:
    cold, read = recorded([20.2, 20.2, 20.2, 20.2]), {"start": "first readings"}
    known = chain().patched({"calibrated": read})
    assert known.calibrated.to_plain()["start"] == "first readings"
    assert compare(known, [cold]).recordings[0].trajectory.sensors["A"][0] == pytest.approx(20.2)
    with pytest.raises(Refused, match=r"calibrated\.start is not 'first readings'"):
        chain().patched({"calibrated": {"start": "cold"}})


def test_a_stated_start_that_the_readings_deny_is_told() -> None:
    warm = replace(recorded([28.0, 28.1, 27.9, 28.0]), start=Start(others=20.0))
    assert [*doubt_starts(chain(), [warm])] == ["r.csv: A is stated to begin at 20.00 degC, and reads 28.00 degC first"]
    assert not [*doubt_starts(chain(), [replace(warm, start=Start(others=27.8))])]
    slow = Column("A", "degC", np.array([20.1, 23.1, 26.1, 28.7]))  # three in the first minute are too few for a line
    rises = Recording("r", "r.csv", np.arange(4) * 26.7, {"A": slow}, start=Start(others=20.0))
    assert not [*doubt_starts(chain(), [rises])]


def test_gaps_in_the_first_readings_are_passed_over() -> None:
    assert begins(recorded([np.nan, 28.0, 28.0, 28.0]))["a"] == pytest.approx(28.0)


def test_a_steady_start_is_where_nothing_moves() -> None:
    """Series of 2, 4, 4, 2 W/K from 40 to 10 °C: 20 W flow, so a is at 30 and b at 20."""
    run = simulate(chain(), schedule([0, 1000.0], start=Start(steady=True)))
    assert run.parts["a"] == pytest.approx(30.0, abs=1e-9)
    assert run.parts["b"] == pytest.approx(20.0, abs=1e-9)


def test_given_temperatures_go_before_the_rules() -> None:
    start = begins(recorded([28.0, 28.0]), start=Start(others=22.0, nodes={"b": 25.0}))
    assert [start["a"], start["b"]] == pytest.approx([22.0, 25.0])


def test_parts_that_a_stated_start_does_not_name_are_read_or_settle() -> None:
    """b between 25 and 10 °C over 2 W/K each: 17.5, not the reference; a, where b is stated, at its first reading."""
    warm = recorded([28.0, 28.0])
    assert begins(warm, start=Start(nodes={"a": 25.0}))["b"] == pytest.approx(17.5, abs=1e-6)
    start = begins(warm, start=Start(nodes={"b": 25.0}))
    assert [start["a"], start["b"]] == pytest.approx([28.0, 25.0])


def test_an_island_has_no_steady_state() -> None:
    island = machine(
        {"a": {"heat_capacity": "1 kJ/K"}},
        sources={"q": {"kind": "heat_source", "into": {"a": 1}, "power": "5 W"}},
    )
    with pytest.raises(Failed, match="no steady state"):
        simulate(island, schedule([0, 10.0], start=Start(steady=True)))


BOMB = [f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]" for old, new in pairwise("abcdefgh")]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[" * 3000, "a value is nested too deeply; at most 40 levels"),
        ("[" * 5, "a bracket is opened here and not closed properly; close it, with commas inside"),
        ("{a: 20 degC, a: 30 degC}", "'a' is given twice; keep one of them"),
        ("{a: &a [*a]}", "'*a' contains itself; take the alias out of what `&a` marks"),
        ("!!python/object:os.system x", "a value has the YAML tag '!!python/object:os.system'; write plain values"),
        (f"{{a: &a [1, 1], {', '.join(BOMB)}}}", "this expands to more than 200000 values"),
        ("", "start: is empty; give a temperature like `22 degC`"),
    ],
)  # fmt: skip
def test_a_start_on_the_command_line_is_read_as_carefully_as_a_file(text: str, told: str) -> None:
    with pytest.raises(Refused) as caught:
        start_of(text)
    assert str(caught.value).startswith(f"--start: {told}")
