"""Recordings of the flagship: the gantry mill with the cooler that it really has, and its user's machine file.

`python -m proof.flagship` from the folder tests/ writes machines/flagship_gantry.yaml, scenarios/flagship_*.csv anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from proof.assembly import Assembly, assemble
from proof.effect import Setting
from proof.effects_heat import ChillerTank
from proof.flagship_machine import FLAGSHIP
from proof.observing import Recording, observe, record
from proof.programs import Program
from proof.written import machine_text

ROOT = Path(__file__).resolve().parents[2]
HOUR = 3600.0
SHOP = ((0.12, 5.3 * HOUR, 0.4), (0.06, 1.7 * HOUR, 2.1))
"""Waves of the shop's air: within 21.4 to 21.8 °C."""
PROGRAMS = {
    "flagship_6000rpm": Program(4 * HOUR, (0.0,), (6000.0,), 21.6, SHOP),
    "flagship_8000rpm": Program(4 * HOUR, (0.0,), (8000.0,), 21.65, SHOP[::-1]),
    "flagship_third_speed": Program(
        4 * HOUR, (0.0, 2524.3, 6127.8, 8006.1), (9000.0, 4500.0, 0.0, 7000.0), 21.55, SHOP
    ),
}
COOLER = {"C": 200e3, "set": 21.3, "P": 1900.0, "UA": 12.0, "delay": 20.0, "slope": 0.015}
"""A tank of 48 l whose compressor takes 1.9 kW while it runs."""
HYSTERESIS = 1.0

HEAD = """\
# The gantry mill of the heat-quantity method as its user writes it down: one lump for each part, and a cooler that is
# believed to keep its coolant at 21 degC. The recordings scenarios/flagship_*.csv are of the machine as it really is,
# made by separate code (tests/proof/flagship.py) on a fine mesh, with something in it that this file does not know.
"""
TAIL = """\
levels:
  fine: {lumps: {shaft: 20, stator: 6, housing: 20, head: 10, beam: 20}}
"""


def machine() -> str:
    """The user's file: numbers off by some 15 %, written with ± 30 %."""
    rng = np.random.default_rng(2014)
    off = {path: value * float(np.exp(0.15 * rng.standard_normal())) for path, value in FLAGSHIP.nominal().items()}
    title, _, rest = machine_text(FLAGSHIP, off).partition("\n")
    return f"{HEAD}{title}\nclosed_form: {{spindle: housing, beam: beam}}\n{rest}{TAIL}"


def true_machine(program: Program, index: int) -> Assembly:
    """The machine as it is: some 15 mm a cell, and its coolant in a tank whose compressor switches."""
    build = assemble(FLAGSHIP, FLAGSHIP.nominal(), fine=True)
    ChillerTank("coolant", HYSTERESIS, Setting(FLAGSHIP, {}), COOLER).conceal(build, program, index)
    return build


def recording(name: str) -> Recording:
    """One recording of the true machine."""
    program, index = PROGRAMS[name], list(PROGRAMS).index(name)
    rng = np.random.default_rng([6000, 8000, index])
    build = true_machine(program, index)
    start = {part: FLAGSHIP.reference + 0.03 * float(rng.standard_normal()) for part in FLAGSHIP.parts}
    times = program.times()
    shown = observe(build, program, {**start, "coolant": 21.0}, times)
    return record(rng, program, times, shown, FLAGSHIP.channels())


def files() -> dict[Path, str]:
    """Every file of the flagship by its path in the repository."""
    texts = {Path("scenarios") / f"{name}.csv": recording(name).text() for name in PROGRAMS}
    return {Path("machines") / "flagship_gantry.yaml": machine(), **texts}


if __name__ == "__main__":
    for path, text in files().items():
        (ROOT / path).write_text(text, encoding="utf-8")
        print(path, len(text.encode()))
