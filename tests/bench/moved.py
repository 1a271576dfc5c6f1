"""`lptn` with some settings of the diagnosis moved: `python -m bench.moved GROUP SHARE diagnose …`.

Nothing in the package knows of it: SETTINGS is replaced in all modules of the diagnosis before the command is called.
"""

from __future__ import annotations

import sys
from dataclasses import fields, replace

from bench.ablated import modules

from network.analysis.diagnosis import settings
from network.analysis.diagnosis.settings import SETTINGS, Settings

GROUPS: tuple[str, ...] = tuple(dict.fromkeys(each["group"] for each in SETTINGS.summary().values()))


def moved(group: str, share: float) -> Settings:
    """All numbers of a group moved by a share, up where it is positive."""
    own = {f.name: f for f in fields(Settings) if f.metadata["group"] == group}
    values = {name: getattr(SETTINGS, name) for name in own}
    return replace(SETTINGS, **{n: moved_number(values[n], own[n].metadata["unit"], share) for n in own})


def moved_number(value: float, unit: str, share: float) -> float:
    """Levels of χ and ratios of them in their excess over 1; shares of 1 in what they are away from the nearer of 0 and
    1; whole numbers by 1 at least, and not below 1."""
    if isinstance(value, int):
        away = max(1, round(abs(share) * value))
        return max(1, value + (away if share > 0 else -away))
    if unit.startswith("χ"):
        return 1 + (value - 1) * (1 + share)
    if unit == "1" and 0.5 < value < 1:
        return 1 - (1 - value) * (1 - share)
    return value * (1 + share)


def put_in_place(those: Settings) -> None:
    """For SETTINGS in all modules of the diagnosis; in those that are not imported yet, where it is a default, too."""
    settings.SETTINGS = those
    for module in modules():
        for word in [word for word, value in vars(module).items() if value is SETTINGS]:
            setattr(module, word, those)


if __name__ == "__main__":
    put_in_place(moved(sys.argv[1], float(sys.argv[2])))
    from network.cli import main

    main(sys.argv[3:])
