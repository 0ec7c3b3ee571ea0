"""The network as a SPICE netlist: the same elements, for another program to solve."""

from __future__ import annotations

from skincad.circuit.network import Constants


def netlist(c: Constants, name: str, low: float = 10.0, high: float = 20_000.0) -> str:
    """Return a SPICE deck: 1 V at node `load` is 1 N, node `vout` is the output with the sign of (9).

    The film's current source beside Cpvd stands as a voltage source d33 lo / Cpvd behind it (Thevenin), so
    that any waveform at `load` gives the charge d33 lo without a derivative.
    """
    return "\n".join(
        [
            f"* {name}: PVDF film and amplifier, 1 V at node load is 1 N",
            "Vload load 0 DC 0 AC 1",
            *element_lines(c),
            f".ac dec 50 {low:g} {high:g}",
            ".print ac vdb(vout)",
            ".end",
            "",
        ]
    )


def element_lines(c: Constants) -> list[str]:
    """Return the deck's elements between node `load` and node `vout`."""
    return [
        f"Epv pv 0 load 0 {c.d33 / c.capacitance!r}",
        f"Cpvd pv film {c.capacitance!r}",
        f"Rmot film m1 {c.motional_resistance!r}",
        f"Lmot m1 m2 {c.motional_inductance!r}",
        f"Cmot m2 0 {c.motional_capacitance!r}",
        f"R12 film in {c.series_resistance!r}",
        f"Ropi in 0 {c.input_resistance!r}",
        f"Copi in 0 {c.input_capacitance!r}",
        f"R34 in out {c.feedback_resistance!r}",
        *([f"C34 in out {c.feedback_capacitance!r}"] if c.feedback_capacitance else []),
        f"Ropo amp out {c.output_resistance!r}",
        f"Eamp amp 0 in 0 {-c.gain!r}",
        "Evout vout 0 out 0 -1",
    ]
