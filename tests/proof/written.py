"""The machine file as its user would have it: the layout, with numbers as the user believes them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from proof.layout import NUMBER, Cooler, Heat, Joint, Layout, Material, Stream

Told = Callable[..., str]
UNITS = {"torque": ("N mm", 1e3), "copper": ("W", 1.0), "iron": ("W", 1.0), "power": ("W", 1.0),
         "power_per_feed": ("W/(m/min)", 1.0)}  # fmt: skip


def machine_text(layout: Layout, believed: Mapping[str, float]) -> str:
    """YAML of the machine: one lump for each part, ± behind every number that is uncertain."""
    spread = {path: s for path, _, s in layout.uncertain()}

    def told(path: str, unit: str, scale: float = 1.0) -> str:
        return f"{believed[path] * scale:.3g} {unit} ± {100 * spread[path]:g} %"

    lines = [f"machine: {layout.title}", f"reference: {layout.reference:g} degC", "materials:"]
    lines += [f"  {name}: {material(stuff)}" for name, stuff in layout.materials.items()]
    lines += ["nodes:", *nodes(layout, told), "links:"]
    lines += [f"  {name}: {link(layout, name, joint, told)}" for name, joint in layout.joints.items()]
    lines += [f"  {name}: {stream(name, each, told)}" for name, each in layout.streams.items()]
    lines += ["sources:", *(f"  {name}: {source(layout, name, heat, told)}" for name, heat in layout.heats.items())]
    lines += [f"  {name}: {cooler(name, each, told)}" for name, each in layout.coolers.items()]
    return "\n".join([*lines, "tcp:", *growths(layout), "sensors:", *sensors(layout)]) + "\n"


def material(stuff: Material) -> str:
    return (
        f"{{density: {stuff.density:g} kg/m^3, specific_heat: {stuff.specific_heat:g} J/(kg K), "
        f"conductivity: {stuff.conductivity:g} W/(m K), expansion: {stuff.expansion:.3g} 1/K}}"
    )


def nodes(layout: Layout, told: Told) -> Iterator[str]:
    for name, part in layout.parts.items():
        words = f"material: {part.material}, length: {part.length * 1e3:g} mm, area: {part.area * 1e4:g} cm^2"
        if part.extra:
            words += f", extra_heat_capacity: {told(f'nodes.{name}.extra_heat_capacity', 'kJ/K', 1e-3)}"
        words += ", rotates: true" if part.turns else ""
        yield f"  {name}: {{{words}, lumps: 1}}"
    for name in layout.vessels:
        yield f"  {name}: {{heat_capacity: {told(f'nodes.{name}.heat_capacity', 'kJ/K', 1e-3)}}}"
    for name in layout.seats:
        yield f"  {name}: {{}}"
    for name, T in layout.held.items():
        yield f"  {name}: {{temperature: {name if T is None else f'{T:g} degC'}}}"


def link(layout: Layout, name: str, joint: Joint, told: Told) -> str:
    number = NUMBER.get(joint.kind, "conductance")
    unit = {"radiation": "m^2", "natural_convection": "W/(m^2 K^1.25)"}.get(joint.kind, "W/K")
    words = f"kind: {joint.kind}, between: [{joint.a}, {joint.b}], {number}: {told(f'links.{name}.{number}', unit)}"
    if joint.kind == "forced_convection":
        gain = told(f"links.{name}.gain", "").replace("  ±", " ±")
        words += f", gain: {gain}, exponent: 0.8, reference_speed: {layout.top_speed:g} rpm"
    if "area" in joint.more:
        words += f", area: {joint.more['area']:g} m^2, exponent: 0.25"
    return f"{{{words}}}"


def stream(name: str, each: Stream, told: Told) -> str:
    flow = told(f"links.{name}.capacity_flow", "W/K")
    return f"{{kind: advection, through: [{', '.join(each.through)}], capacity_flow: {flow}}}"


def cooler(name: str, each: Cooler, told: Told) -> str:
    switches = f"set: {each.set:g} degC, hysteresis: {each.hysteresis:g} K"
    where = f"into: {{{each.at}: 1}}, watches: {each.at}"
    return f"{{kind: thermostat_cooling, {where}, {switches}, power: {told(f'sources.{name}.power', 'W')}}}"


def source(layout: Layout, name: str, heat: Heat, told: Told) -> str:
    into = ", ".join(f"{place}: {share:g}" for place, share in heat.into.items())
    numbers = ", ".join(f"{key}: {told(f'sources.{name}.{key}', *UNITS[key])}" for key in heat.numbers)
    more = {
        "motor_loss": f", iron_exponent: 1.5, reference_speed: {layout.top_speed:g} rpm",
        "heat_source": ", with: always",
    }
    return f"{{kind: {heat.kind}, into: {{{into}}}, {numbers}{more.get(heat.kind, '')}}}"


def growths(layout: Layout) -> Iterator[str]:
    for axis in dict.fromkeys(growth.axis for growth in layout.growths.values()):
        yield f"  {axis}:"
        for name, g in layout.growths.items():
            if g.axis == axis:
                length = f"length: {g.length * 1e3:g} mm, direction: {g.direction}"
                yield f"    {name}: {{kind: stretching, of: {g.of}, {length}}}"


def sensors(layout: Layout) -> Iterator[str]:
    for name, place in layout.sensors.items():
        moved = place.startswith("tcp.")
        noise = "0.25 um" if moved else "0.05 K"
        yield f"  {name}: {{measures: {place}, noise: {noise}{', zero: start' if moved and layout.zeroed else ''}}}"
