from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.entry_path import NumberPath, axis_of, displacement
from network.catalogue.declaration.fields import Place, param, parse_place, place, whole, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.proposals import fresh
from network.catalogue.expansions.base import LINEAR_AXES
from network.catalogue.suspects.base import Suspect
from network.catalogue.typical_values import usual_surroundings

STEEL = "1.13e-5 1/K"


class Post(Suspect, kind="post"):
    """A hidden part between another and the surroundings that grows: C dT/dt = G (T_near − T) + G_s (T_air − T).

    It moves the tool by α L (T − T_ref), α that of steel: the holder of a switch beside a heated bed, a bracket of the
    scale. What it stands near may be held at an input, too. It follows with the time constant C/(G + G_s) and settles
    at (G T_near + G_s T_air)/(G + G_s); a stretching of a known part follows that part at once. All of C, G and G_s
    scale together, so `loss` stays as it is where a fit looks for the others. Not looked for by a diagnosis: as many
    as nodes times axes, each a run of its own. Source: balance of one lumped mass.
    """

    near = place("the node it is tied to, which may be held")
    surroundings = place("the node it loses heat to")
    moves = word("the axis along which it moves the tool", *map(displacement, LINEAR_AXES))
    direction = whole("which way it moves the tool centre point: 1 or −1", -1, 1, allowed=(1, -1))
    heat_capacity = param("kJ/K", 0, 1e4, "its heat capacity", positive=True, typical=0.2)
    conductance = param("W/K", 0, 1e4, "conductance between it and what it stands near", typical=0.3)
    loss = param("W/K", 0, 1e4, "conductance between it and the surroundings", positive=True, typical=0.3)
    length = param("mm", 0, 10_000, "length that grows", positive=True, typical=60)
    strength = "length"
    searched = False
    shapes = ("heat_capacity", "conductance")
    sentence = "a post near {near} of {heat_capacity}, joined by {conductance}, grows over {length} and moves {way}"

    @property
    def way(self) -> str:
        """The axis with the sign of its direction."""
        return f"the tool along {'+' if self.direction > 0 else '-'}{axis_of(self.moves)}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        axis = axis_of(self.moves) or ""
        name = fresh(f"post near {self.near.node}", {*machine.nodes, *machine.links, *machine.tcp.get(axis, ())})
        around = {"kind": "convection", "between": [name, str(self.surroundings)]}
        loss = self.fields["loss"].write(self.loss)
        tie = {"kind": "conduction", "between": [str(self.near), name], **self.write_numbers("conductance")}
        grows = {"kind": "stretching", "of": name, "expansion": STEEL, "direction": int(self.direction)}
        return {
            "nodes": {name: self.write_numbers("heat_capacity")},
            "links": {name: tie, f"{name} to surroundings": {**around, "conductance": loss}},
            "tcp": {axis: {name: {**grows, **self.write_numbers("length")}}},
        }

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Near every part and every held node, along every axis, each way, where other surroundings remain."""
        for name, node in machine.nodes.items():
            around = usual_surroundings(machine, besides=name)
            if node.is_massless or around is None:
                continue
            for axis in (a for a in machine.tcp if a in LINEAR_AXES):
                for direction in (1, -1):
                    own = {"moves": displacement(axis), "direction": direction}
                    yield cls.typical(near=Place(name), surroundings=Place(around), **own)

    @classmethod
    def path_to(cls, parameter: str, patch: Mapping[str, Any]) -> NumberPath:
        if parameter != "loss":
            return super().path_to(parameter, patch)
        links = [path for path, _ in Patch(patch).entries() if path.section == "links"]
        return NumberPath(links[1], "conductance")

    @classmethod
    def from_patch(cls, machine: MachineLike, patch: Mapping[str, Any]) -> Self:
        tie, around = patch["links"].values()
        ((axis, grown),) = patch["tcp"].items()
        (grows,) = grown.values()
        numbers = {name: cls._read_back(field, machine.by_path, patch) for name, field in cls.params().items()}
        words = {"moves": displacement(axis), "direction": grows["direction"]}
        near, surroundings = parse_place(tie["between"][0]), parse_place(around["between"][1])
        return cls(near=near, surroundings=surroundings, **words, **numbers)
