"""Mutants by their number: the files and the words of a command, the same for the same seed and number."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from network import Machine, Scenario, simulate
from network.recordings.csv_table import write_csv
from torture.mutations import hostile, mutate_csv, mutate_letters, mutate_yaml

ROOT = Path(__file__).parents[2]
PAIRS = (
    ("two_blocks", "bearing_warms"), ("three_blocks", "band_heater"), ("gantry_spindle", "warm_up_and_stop"),
    ("belt_lathe", "constant_3000"), ("heated_building", "heating_by_day"), ("toaster_oven", "oven_on_and_off"),
    ("ball_screw_axis", "axis_back_and_forth"), ("vertical_mill", "warm_up_and_stop"),
)  # fmt: skip
TURNING = (("gantry_spindle", "iso230_spindle_constant"), ("vertical_mill", "iso230_spindle_constant"))
"""For commands that need a spindle."""
SMALL = ("two_blocks", "bearing_warms")
COMMANDS = {
    "check": 0.65, "simulate": 0.15, "compare": 0.07, "sweep": 0.025, "calibrate": 0.02, "diagnose": 0.01,
    "export": 0.015, "iso230": 0.015, "warmup": 0.01, "draft": 0.015, "follow": 0.01, "draw": 0.01,
}  # fmt: skip
"""A third of them compute."""
PIPED = "stdin.csv"
"""The file of a mutant that its command is given on standard input."""
OPTIONS = (
    ("--lumps", ("1", "3", "40", "0", "-1", "2000", "hot=2", "nope=3", "1e9", "")),
    ("--level", ("paper", "coarse", "fine", "", "x")),
    ("--start", ("22 degC", "steady", "{hot: 30 degC}", "", "nan degC", "1e9 degC", "[[", "estimated")),
)
MAPPING = """recording: mapped
file: r.csv
columns:
  "time [s]": "time [s]"
  "T_hot [degC]": "T_hot [degC]"
  "T_cold [degC]": "T_cold [degC]"
  "ambient [degC]": "ambient [degC]"
"""


@dataclass(frozen=True)
class Mutant:
    """files: name → text, to be put into an empty folder; words: of the command that is given them."""

    files: Mapping[str, str]
    words: tuple[str, ...]

    def write(self, where: Path) -> None:
        for name, text in self.files.items():
            (where / name).write_bytes(text.encode("utf-8", "replace"))


@cache
def shipped(name: str, room: str) -> str:
    return (ROOT / room / f"{name}.yaml").read_text(encoding="utf-8")


@cache
def recorded(folder: Path) -> str:
    """A recording of the small machine, with noise, 200 samples."""
    pair = Machine.load(ROOT / f"machines/{SMALL[0]}.yaml"), Scenario.load(ROOT / f"scenarios/{SMALL[1]}.yaml")
    run = simulate(*pair, noise_seed=1)
    some = np.linspace(0, len(run.t) - 1, 200).astype(int)
    columns = {name: (unit_text, values[some]) for name, unit_text, values in run.columns_in_si() if name != "tcp.z"}
    write_csv(folder / "recorded.csv", run.t[some], columns)
    return (folder / "recorded.csv").read_text(encoding="utf-8")


def mutant(seed: int, number: int, folder: Path) -> Mutant:
    """folder: where a recording may be made once."""
    chance = random.Random(f"{seed}/{number}")
    command = chance.choices([*COMMANDS], [*COMMANDS.values()])[0]
    fits = command in ("compare", "calibrate", "diagnose", "draft")
    name, by = SMALL if fits or chance.random() < 0.4 else chance.choice(PAIRS)
    name, by = chance.choice(TURNING) if command in ("iso230", "warmup") else (name, by)
    files = {"m.yaml": shipped(name, "machines"), "s.yaml": shipped(by, "scenarios"), "r.csv": recorded(folder)}
    files["map.yaml"] = MAPPING
    source = chance.choice(("r.csv", "r.csv", "map.yaml") if fits else ("s.yaml", "s.yaml", "r.csv", "map.yaml"))
    source = source if name == SMALL[0] else "s.yaml"
    aims = ["m.yaml", source, *(["r.csv"] if source == "map.yaml" else [])]
    for aim in {chance.choice(aims), *(aims if chance.random() < 0.15 else ())}:
        change = mutate_csv if aim.endswith(".csv") else mutate_yaml
        files[aim] = change(files[aim], chance)
    if chance.random() < 0.03:
        files["m.yaml"] = mutate_letters(files["m.yaml"], chance)
    if command in ("draft", "follow"):
        source = "r.csv" if command == "draft" else PIPED
        files[source] = mutate_csv(files["r.csv"], chance)
    given = [*(["m.yaml"] if command != "draft" else []), *([source] if command not in ("follow", "draw") else [])]
    words = [command, *given, *_options(command, chance)]
    used = {*words, *(["r.csv"] if source == "map.yaml" else []), *([PIPED] if command == "follow" else [])}
    return Mutant({file: text for file, text in files.items() if file in used}, tuple(words))


def _sweep_words(chance: random.Random) -> list[str]:
    vary = ["--vary", f"links.joint.conductance={hostile(chance)}"]
    return ["--levels", "1,2"] if chance.random() < 0.7 else vary


def _export_words(chance: random.Random) -> list[str]:
    words = ["--as", chance.choice(("c", "table", "sinumerik", "heidenhain", "beckhoff", "x"))]
    words += ["--states", chance.choice(("1", "3", "0", "1000"))] if chance.random() < 0.3 else []
    return words + (["--step", hostile(chance)] if chance.random() < 0.2 else [])


METHODS = ("rosenbrock", "expm", "krylov", "solve_ivp:LSODA", "solve_ivp:RK45", "modal", "x", "")


def _now_and_then(chance: random.Random, flags: tuple[str, ...], methods: tuple[str, ...]) -> list[str]:
    words = [flag for flag in flags if chance.random() < 0.04]
    return words + (["--method", chance.choice(methods)] if chance.random() < 0.08 else [])


OWN = {
    "sweep": _sweep_words,
    "export": _export_words,
    "diagnose": lambda chance: ["--jobs", "1", "--budget", chance.choice(("5 s", "20 s", hostile(chance)))],
    "warmup": lambda chance: ["--tolerance", "5 um" if chance.random() < 0.8 else hostile(chance), "--longest", "1 h"],
    "draft": lambda chance: ["-o", "out.yaml"] if chance.random() < 0.5 else [],
    "draw": lambda chance: ["-o", chance.choice(("out.svg", "out/x.png", "out", "out.pdf", hostile(chance)))],
    "follow": lambda chance: ["--state", "state.json"] if chance.random() < 0.5 else [],
    "simulate": lambda chance: _now_and_then(chance, ("--page", "--noise", "--json"), METHODS),
    "compare": lambda chance: _now_and_then(chance, ("--page",), METHODS),
}
"""Words that belong to a command."""
WITHOUT_START = ("check", "sweep", "export", "warmup", "follow", "draw")


def _options(command: str, chance: random.Random) -> list[str]:
    words = list(OWN.get(command, lambda chance: [])(chance))
    if command not in ("check", "draft", "draw", "follow") and chance.random() < 0.9:
        words += ["-o", "out"]
    if command in ("simulate", "calibrate", "diagnose", "compare") and chance.random() < 0.97:
        words.append("--no-plots")
    if command == "draft":
        return words
    for option, values in OPTIONS:
        if chance.random() < 0.04 and not (command in WITHOUT_START and option == "--start"):
            words += [option, chance.choice(values)]
    if chance.random() < 0.08:
        at = chance.choice(("nodes.hot", "links.joint.conductance", "sensors.T_hot.noise"))
        words += ["--set", f"{at}={hostile(chance)}"]
    return words
