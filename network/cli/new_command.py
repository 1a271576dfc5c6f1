"""The command `lptn new`."""

from __future__ import annotations

from pathlib import Path

import click

from network.platform.refusal import Complaints, Spot

MACHINE, DAY = "new_machine.yaml", "new_machine_day.yaml"


@click.command()
@click.option("-o", "--output", type=click.Path(), metavar="FILE", help="the machine file; printed without")
def new(output: str | None) -> None:
    """A commented machine file to start from: parts, three axes, chiller, sensors and the tool centre point. With -o, a
    scenario for it is written beside."""
    from network.platform.files import write_text
    from network.platform.folders import folder
    from network.platform.package_data import find_shipped

    machine, day = (find_shipped(*place).read_text(encoding="utf-8")
                    for place in (("machines", MACHINE), ("scenarios", DAY)))  # fmt: skip
    if output is None:
        click.echo(machine, nl=False)
        return
    path = Path(output)
    beside = path.with_name(f"{path.stem}_day{path.suffix}")
    _check_targets(path, beside)
    folder(path.parent)
    write_text(path, machine)
    write_text(beside, day)
    click.echo(f"Written: {path}, {beside}")
    click.echo(f"Next: lptn check {path}\n      lptn simulate {path} {beside} -o out/first")


def _check_targets(*paths: Path) -> None:
    """A file that was worked on is never replaced."""
    complaints = Complaints()
    for path in paths:
        if path.suffix.lower() not in (".yaml", ".yml"):
            complaints.refuse(Spot(str(path)), "is no machine file", "end it in .yaml")
        elif path.exists():
            complaints.refuse(Spot(str(path)), "is there already", "give another -o, or move it away")
    complaints.raise_if_any()
