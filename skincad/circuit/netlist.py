"""The network as a SPICE netlist: the same elements, for another program to solve."""

from __future__ import annotations

from skincad.circuit.elements import Network, Source


def netlist(network: Network, name: str, low: float = 10.0, high: float = 20_000.0) -> str:
    """Return a SPICE deck: 1 V at node `load` is 1 N, node `vout` is the output."""
    return "\n".join(
        [
            f"* {name}: PVDF film and amplifier, 1 V at node load is 1 N",
            "Vload load 0 DC 0 AC 1",
            *element_lines(network),
            f".ac dec 50 {low:g} {high:g}",
            ".print ac vdb(vout)",
            ".end",
            "",
        ]
    )


def element_lines(network: Network) -> list[str]:
    """Return the deck's elements between node `load` and node `vout`."""
    return [
        f"{e.name} {e.a} 0 {e.plus} {e.minus} {e.value!r}"
        if isinstance(e, Source)
        else f"{e.name} {e.a} {e.b} {e.value!r}"
        for e in network.elements
    ]
