"""The job of `skincad circuit`: gain, picture, netlist and calibrated constants in one folder."""

from __future__ import annotations

from pathlib import Path

import tomlkit

from skincad.base.outfolder import checked_folder, replaced
from skincad.base.stopwatch import Progress
from skincad.base.strictjson import strict_json
from skincad.circuit.bode import CircuitGain, circuit_gain
from skincad.circuit.film import PICO, capacitance
from skincad.circuit.model import Circuit
from skincad.circuit.netlist import netlist

NAMES = ("gain.csv", "netlist.cir", "gain.png", "calibrated.toml")  # the last one with measured data


def circuit_job(
    circuit: Circuit,
    folder: Path | str | None = None,
    *,
    measured: Path | str | None = None,
    progress: Progress | None = None,
) -> tuple[CircuitGain, list[dict[str, str | int]]]:
    """Return the gain of a circuit and the files written into `folder` (default out/<name>), path and bytes.

    gain.csv, gain.png, netlist.cir, and with measured data calibrated.toml: whole or not at all. Raises
    InputError for bad input.
    """
    target = Path("out") / circuit.name if folder is None else Path(folder)
    checked_folder(target, "circuit", NAMES if measured is not None else NAMES[:-1])
    from skincad.pictures.circuit_figures import gain_picture

    found = circuit_gain(circuit, measured, progress)
    strict_json(found.as_json())  # before anything is written: the manifest tells its name alone
    with replaced(target, "circuit", {"name": found.name}) as staging:
        (staging / "gain.csv").write_text(gain_csv(found), encoding="utf-8")
        sweep = circuit.sweep
        deck = netlist(found.constants, found.name, sweep.low, sweep.high)
        (staging / "netlist.cir").write_text(deck, encoding="utf-8")
        gain_picture(found, staging / "gain.png")
        if found.measured:
            (staging / "calibrated.toml").write_text(calibrated_toml(found), encoding="utf-8")
        sizes = {path.name: path.stat().st_size for path in sorted(staging.iterdir())}
    return found, [{"path": str(target / name), "bytes": size} for name, size in sizes.items()]


def gain_csv(found: CircuitGain) -> str:
    """Return the gain as CSV: dB re 1 V/N, and the level of a measured curve by `sweep.offset`."""
    rows = zip(found.frequency, found.gain, found.gain - found.circuit.sweep.offset, strict=True)
    lines = [f"{f:.8g},{g:.6f},{m:.6f}" for f, g, m in rows]
    return "\n".join(["frequency_Hz,gain_dB,gain_less_offset_dB", *lines]) + "\n"


def calibrated_toml(found: CircuitGain) -> str:
    """Return the circuit with the calibrated constants, to be used in its place.

    Film and lead share the calibrated capacitance: what the film's size does not give is the lead's, and a
    film that has more than the whole gets a smaller electrode.
    """
    if found.measured is None:
        raise ValueError("nothing was calibrated")
    c, circuit, fit = found.constants, found.circuit, found.measured.calibration
    film = circuit.film
    own = capacitance(film.area, film.thickness, film.permittivity)
    area = film.area * min(1.0, c.capacitance / own)
    data = circuit.model_dump(exclude_none=True)
    data["film"] = {**data["film"], "area": area, "d33": c.d33 / PICO}
    data["cable"] = {"capacitance": max(0.0, c.capacitance - own)}
    data["motional"] = {key: getattr(c, f"motional_{key}") for key in data["motional"]}
    data["amplifier"] = {key: getattr(c, key) for key in data["amplifier"]}
    head = f"# {found.name}, calibrated to a measured curve: {fit.rms:.2g} dB rms\n"
    return head + tomlkit.dumps(data)
