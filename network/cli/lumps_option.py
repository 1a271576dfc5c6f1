"""`--lumps auto`: as many for every bar as keep each channel within a tolerance along what a command is given."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from network.machine.overrides import AUTO, is_auto
from network.platform.refusal import Spot, refuse, short
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration
    from network.machine.machine import Machine
    from network.recordings.inputs import Start
    from network.recordings.recording import Recording
    from network.recordings.scenario import Scenario


def split_wishes(lumps: Sequence[str]) -> tuple[list[str], str | None]:
    """What names numbers, and what asks for them to be chosen."""
    autos = [wish for wish in lumps if is_auto(wish)]
    if len(autos) > 1:
        raise refuse(Spot("--lumps"), "asks for `auto` twice", "give it once")
    numbers = [wish for wish in lumps if not is_auto(wish)]
    if autos and not all("=" in wish for wish in numbers):
        right = "name the bars that are to stay, as in --lumps auto --lumps housing=4"
        raise refuse(Spot("--lumps"), "asks for `auto` and for one number in every bar", right)
    return numbers, autos[0] if autos else None


def read_share(wish: str) -> float:
    """`auto`, or `auto:1 %`: the share of its range that each channel may be off."""
    from network.analysis.sweep.finer_lumps import SHARE

    tolerance = wish.strip().removeprefix(AUTO).lstrip(": ").strip()
    if not tolerance:
        return SHARE
    found = re.fullmatch(r"([0-9.]+)\s*%", tolerance)
    if not found or found[1].count(".") > 1 or not 0.01 <= float(found[1].strip(".") or 0) <= 50:
        right = "write `--lumps auto`, or a share of every channel's range, 'auto:1 %' (0.01 to 50 %)"
        raise refuse(Spot(f"--lumps {short(wish)}"), f"'{short(tolerance)}' is no tolerance", right)
    return float(found[1]) / 100


def cut_as_wished(
    machine: Machine, wish: str | None, numbers: Sequence[str], sources: Sequence[Scenario | Recording],
    start: Start | None = None,
) -> Machine:  # fmt: skip
    """The machine cut so finely as its channels along the sources need it, and told on standard error; as it is where
    nobody wishes that."""
    if wish is None:
        return machine
    from network.analysis.sweep.finer_lumps import CHOSEN, cut_bars
    from network.analysis.sweep.lump_choice import choose_lumps
    from network.analysis.sweep.usual_program import usual_program

    share, keep = read_share(wish), [number.rpartition("=")[0].strip() for number in numbers]
    with share_bar("choosing lumps") as bar:
        known = _guess_unknown(machine)
        along = sources or [usual_program(known)]
        choice = choose_lumps(known, along, share=share, keep=keep, start=start, progress=bar)
    told = "" if sources else " No schedule is given: along a warm-up and rest."
    click.echo(f"{choice}{told}", err=True)
    chosen = {name: count for name, count in choice.lumps.items() if name not in keep}
    return cut_bars(machine, chosen, Spot(f"{CHOSEN}{wish.strip().removeprefix(AUTO)}"))


def choose_again(
    machine: Machine, result: Calibration, recordings: Sequence[Recording], start: Start | None
) -> Machine | None:
    """The machine with lumps chosen by the numbers of its calibration, told on standard error; None where those that
    were chosen before are enough, or nobody wished that."""
    from network.analysis.sweep.finer_lumps import bars_of, chosen_bars, cut_bars
    from network.analysis.sweep.lump_choice import choose_lumps

    spots = chosen_bars(machine)
    if result.cut is None or result.cut.is_within or not spots:
        return None
    place = next(iter(spots.values()))
    keep, share = bars_of(machine).keys() - spots, read_share(place.file.removeprefix("--lumps "))
    choice = choose_lumps(result.machine, recordings, share=share, keep=keep, start=start)
    lumps = {name: max(choice.lumps[name], machine.nodes[name].lumps) for name in spots}
    if all(machine.nodes[name].lumps == count for name, count in lumps.items()):
        return None
    click.echo(f"With the numbers found: {choice}", err=True)
    return cut_bars(machine, lumps, place)


def _guess_unknown(machine: Machine) -> Machine:
    """Numbers that are still `unknown` at the middle of their range."""
    from network.engine.response.parameters import free_parameters
    from network.machine.overrides import set_value

    tree = machine.tree
    for p in free_parameters(machine):
        if p.is_unknown:
            tree = set_value(tree, f"{p.path}={p.format_value(p.centre)}")
    return machine if tree is machine.tree else type(machine).read(tree, machine.file)
