"""The detector of a design or a scene, as commands make it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from skincad.base.errors import InputError
from skincad.cli import options
from skincad.cli.options import option

if TYPE_CHECKING:
    from skincad.circuit.model import Circuit
    from skincad.detector.detector import Detector
    from skincad.inputs.design import Design

CIRCUIT = "transimpedance"  # where neither an option nor a scene names one


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
    alarms: Annotated[
        str | None,
        option("--alarms POINT", "sure: few false alarms, or early; default: the scene's, or sure."),
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
    `readout.ridges` and its `readout.alarms`; `wiring` comes before all of these. Raises InputError for a
    circuit in the place of a design, for ridges that are no numbers, and as `Detector` does.
    """
    from skincad.circuit.model import Circuit, load_circuit
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
    detector = Detector(
        design,
        circuit,
        rate if wiring.rate is None else wiring.rate,
        ridges if wiring.ridges is None else _numbers(wiring.ridges),
        alarms=alarms if wiring.alarms is None else wiring.alarms,
        noise=wiring.noise,
        every=1 if wiring.every is None else wiring.every,
    )
    return detector, design, circuit


def _numbers(text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise InputError("ridges", "must be numbers", text, "as in 3,4,5,6") from None
