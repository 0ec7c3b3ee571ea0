"""The detector of a design or a scene, as commands make it, and the command that exports it: `export`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import skincad
from skincad.base.errors import InputError
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import argument, option
from skincad.cli.printing import deliver, out_folder

if TYPE_CHECKING:
    from skincad.circuit.model import Circuit
    from skincad.detector.detector import Detector
    from skincad.inputs.design import Design

CIRCUIT = "single-supply"  # where neither an option nor a scene names one


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """Which films the detector hears, and how; what is None is the scene's, or as `Detector` has it."""

    circuit: Annotated[
        str | None,
        option(
            "--circuit CIRCUIT",
            f"A template's name or a TOML file; default: the scene's, or {CIRCUIT}.",
            autocompletion=options.completes("circuits"),
        ),
    ] = None
    ridges: Annotated[
        str | None, option("--ridges LIST", "The wired ridges, as 3,4,5,6; default: the scene's, or all.")
    ] = None
    rate: Annotated[
        float | None, option("--rate HZ", "Samples per second; default: the scene's, or the circuit's.")
    ] = None
    bandwidth: Annotated[
        float | None,
        option(
            "--bandwidth HZ", "Of the low-pass before the samples; default: 0.4 of the rate, or the scene's."
        ),
    ] = None
    alarms: Annotated[
        str | None,
        option(
            "--alarms POINT",
            "sure: few false alarms; early; grip: for a gripper; default: the scene's, or sure.",
        ),
    ] = None
    noise: Annotated[
        float | None,
        option("--noise V", "Noise of a ridge's S1 - S2, V rms; default: of film and amplifier alone."),
    ] = None
    every: Annotated[int | None, option("--every N", "Decide at each Nth sample only: N times cheaper.")] = (
        None
    )


def detector_of(
    source: str, settings: list[str], wiring: Wiring, workshop: options.Workshop | None = None
) -> tuple[Detector, Design, Circuit]:
    """Return the detector of a design's or a scene's name or TOML file, with its design and its circuit.

    Of a scene it is that of its skin, the circuit and the `sampling_Hz` of its `effects.piezo`, its
    `readout.ridges` and `readout.alarms`, and its `readout.bandwidth_Hz` where the samples show that;
    `wiring` comes before all of these. Raises InputError for a circuit in the place of a design, for ridges
    that are no numbers, and as `Detector` does.
    """
    from skincad.circuit.model import Circuit, load_circuit
    from skincad.circuit.state import PASS
    from skincad.detector.detector import SURE, Detector
    from skincad.effects.piezo import Piezo
    from skincad.scenes.scene import Scene
    from skincad.studies.subject import load_subject

    subject = load_subject(source, settings, **vars(workshop or options.Workshop()))
    if isinstance(subject, Circuit):
        raise InputError(source[:80], "is a circuit, not a design or a scene", remedy="give it to --circuit")
    circuit, rate, ridges, alarms = None, None, None, SURE
    design = subject.design if isinstance(subject, Scene) else subject
    if isinstance(subject, Scene):
        ridges, alarms = subject.readout.ridges or None, subject.readout.alarms
        if isinstance(reader := subject.parts.get("piezo"), Piezo) and wiring.circuit is None:
            circuit, rate = reader.loaded, reader.sampling_Hz
    if circuit is None:
        circuit = load_circuit(CIRCUIT if wiring.circuit is None else wiring.circuit)
    made = partial(
        Detector,
        design,
        circuit,
        rate if wiring.rate is None else wiring.rate,
        ridges if wiring.ridges is None else _numbers(wiring.ridges),
        alarms=alarms if wiring.alarms is None else wiring.alarms,
        noise=wiring.noise,
        every=1 if wiring.every is None else wiring.every,
    )
    detector = made(bandwidth=wiring.bandwidth)
    if wiring.bandwidth is None and isinstance(subject, Scene):
        detector = made(bandwidth=min(subject.readout.bandwidth_Hz, PASS * detector.rate / 2))
    return detector, design, circuit


def _numbers(text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise InputError("ridges", "must be numbers", text, "as in 3,4,5,6") from None


def export(
    source: Annotated[str, argument("DESIGN|SCENE", "A template's name or a TOML file.")],
    settings: options.Settings = [],  # noqa: B006
    folder: Annotated[
        Path | None,
        option("--detector DIR", "The folder for the detector's C code; default: out/<name>/detector."),
    ] = None,
    *,
    wiring: Wiring,
    workshop: options.Workshop,
    as_json: options.Json = False,
) -> None:
    """Write the slip detector as C code for a microcontroller.

    C99 without allocation, its weights, test vectors, and a sketch for a Teensy 4.1 that samples, prints and
    alarms. Without --every it decides as often as half of a Cortex-M7 of 600 MHz allows.
    """
    from skincad.outputs import detector_code

    detector, design, circuit = detector_of(source, settings, wiring, workshop)
    if wiring.every is None:
        every = detector_code.fitting_every(len(detector.ridges), detector.rate, detector.tuning.network)
        if every is None:
            rule = f"is too fast for {len(detector.ridges)} ridges on a Cortex-M7 of 600 MHz"
            remedy = "give a lower --rate or fewer --ridges; or --every for another processor"
            raise InputError("rate", rule, detector.rate, remedy)
        detector, _, _ = detector_of(source, settings, replace(wiring, every=every), workshop)
    result = skincad.export(detector, name=f"{design.name} behind {circuit.name}")
    target = out_folder(folder, Path(design.name, "detector"), detector_code.COMMAND, detector_code.NAMES)
    with stage_bar(1) as progress:
        written = skincad.write(result, target, progress=progress)
    deliver(result, written, options.Display(as_json=as_json))
