"""The commands that run a scene or a detector: `simulate`, `live`, `listen`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING, Annotated, Any

import skincad
from skincad.base.errors import InputError
from skincad.base.interrupt import safe_point
from skincad.base.progress import step_bar
from skincad.cli import options
from skincad.cli.detectors import Wiring, detector_of
from skincad.cli.options import option
from skincad.cli.printing import as_typed, deliver, leave, out_folder, report, say, show

if TYPE_CHECKING:
    from skincad.detector.detector import Detector
    from skincad.detector.listening import Listener, RecordingFile
    from skincad.detector.wire import Block, Wire
    from skincad.inputs.recordings import FilmRecording


def simulate(
    source: Annotated[str, options.argument("SCENE", autocompletion=options.completes("scenes"))],
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    tol: Annotated[
        float | None, option("--tol REL", "Relative error of the differential stress to meet.")
    ] = None,
    budget: options.Budget = None,
    model: Annotated[
        str,
        option("--model", "auto: with finite strain and free ends where they matter; or small_strain alone."),
    ] = "auto",
    at: Annotated[
        list[int], option("--at STEP", "Draw the section with its stress at this step; repeat for several.")
    ] = [],  # noqa: B006
    gif: Annotated[bool, option("--gif", "Animate the section over the scene.")] = False,
    folder: options.Out = None,
    *,
    display: options.Display,
) -> None:
    """Run a scene, and say which ridge slips when.

    The effects that the scene names are computed, and those that change its signals most. Signals as CSV and
    a picture appear in the output folder; Ctrl-C keeps what is done by then.
    """
    from skincad.inputs.catalog import setting_key

    for key, name, value in (("readout.steps", "at", at), ("readout.frames", "gif", gif)):
        if value and key in map(setting_key, settings):
            raise InputError(name, f"gives {key}, and --set does too", remedy="leave one of them out")
    drawn = [f"readout.steps={at}"] * bool(at) + ["readout.frames=24"] * gif
    try:
        scene = skincad.load_scene(source, [*settings, *drawn], silicones=silicones)
    except InputError as failure:
        if not (at and failure.key.startswith("readout.steps")):
            raise
        raise InputError("at", failure.rule, failure.value, failure.remedy) from None
    from skincad.outputs import simulations

    target = out_folder(folder, scene.name, simulations.COMMAND, simulations.names(scene))
    with step_bar(scene.history.step_count) as tick:
        result = skincad.simulate(
            scene,
            tol=tol,
            budget=budget,
            tick=tick,
            partial=True,
            model=model,  # type: ignore[arg-type]
        )
    typed = as_typed(source, settings, silicones=silicones)
    deliver(result, skincad.write(result, target), display, typed)
    leave(result)


def live(
    source: Annotated[
        str, options.argument("DESIGN", "A template's name or a TOML file: a design or a scene.")
    ],
    settings: options.Settings = [],  # noqa: B006
    host: Annotated[
        str, option("--host ADDRESS", "Where to listen; default: this machine alone.")
    ] = "127.0.0.1",
    port: Annotated[int, option("--port N", "The port, or the next free one; 0: any.")] = 8642,
    browser: Annotated[bool, option("--open", "Open it in the browser.")] = False,
    *,
    workshop: options.Workshop,
) -> None:
    """Move a design or scene with sliders, in the browser.

    Section, skin and mold follow each move; findings and the closed form's verdict come at once, those of
    better models as they finish. A scene's history and signals are plots. Undo, save as TOML, make. Ctrl-C
    ends.
    """
    from skincad.circuit.model import Circuit
    from skincad.live.serve import serve
    from skincad.scenes.scene import Scene
    from skincad.studies.subject import load_subject

    subject = load_subject(source, settings, **vars(workshop))
    if isinstance(subject, Circuit):
        raise InputError(source[:80], "is a circuit, not a design or a scene", remedy="give it to circuit")
    if isinstance(subject, Scene) and subject.grip is not None:
        raise InputError("grip", "is not shown live", remedy="give the scene to simulate")
    serve(subject, source, host, port, browser=browser, say=say)


def listen(
    sources: Annotated[
        list[str],
        options.argument(
            "DESIGN|SCENE [-]", "A template's name or a TOML file; - reads lines from standard input."
        ),
    ],
    port: Annotated[
        str | None, option("--port PORT", "A board's serial port, as /dev/ttyACM0, or socket://HOST:PORT.")
    ] = None,
    recorded: Annotated[
        str | None, option("--csv FILE", "A recording: columns time_s and a strip each, as ridge_3_S1_V.")
    ] = None,
    record: Annotated[
        Path | None, option("--record FILE", "Write what comes as a CSV, which --csv reads again.")
    ] = None,
    taps: Annotated[
        bool,
        option("--taps", "Tap ridge after ridge: names dead, swapped, reversed, weak and clipped channels."),
    ] = False,
    page: Annotated[bool, option("--page", "Show channels and alarms in the browser, here alone.")] = False,
    baud: Annotated[
        int, option("--baud N", "Of a serial port that needs it; USB boards take any.")
    ] = 115_200,
    timeout: Annotated[
        float | None,
        option("--timeout S", "Silence that ends it; default: 2 s of a port, any of standard input."),
    ] = None,
    rest: Annotated[
        float, option("--rest S", "How long nothing touches at first; 0: it rests at 0 V.")
    ] = 0.5,
    settings: options.Settings = [],  # noqa: B006
    silicones: options.Silicones = None,
    *,
    wiring: Wiring,
    display: options.Display,
) -> None:
    """Hear slip in the films' voltages, from a board or a recording.

    Prints a JSON line for each alarm as it comes, for lost samples and for a board that restarts, and at the
    end a summary. Nothing may touch the skin in the first half second (--rest): its mean is the resting
    voltage. Ctrl-C ends it and keeps the recording. --taps judges the channels instead, by a tap on each
    ridge.
    """
    from skincad.detector import listening

    source, *more = sources
    if more == ["-"] and recorded is None:
        more, recorded = [], "-"
    if more or (port is None) == (recorded is None):
        rule = "must be a design or scene, and one of --port PORT, --csv FILE and -"
        raise InputError("arguments", rule, " ".join(sources), "see `skincad listen --help`")
    beside = {"page": page, "rest": rest != listening.REST_SECONDS}
    if taps and any(beside.values()):
        raise InputError(max(beside, key=beside.__getitem__), "is not of --taps", remedy="leave it out")
    detector, design, _ = detector_of(source, settings, wiring, options.Workshop(silicones=silicones))
    listener = listening.Listener(detector, rest)
    recording = None
    if record is not None:
        if port is None and recorded != "-":
            raise InputError("record", "is of a port or of standard input", str(record), "leave it out")
        recording = listening.RecordingFile(record, f"{source}, {port or 'standard input'}", detector.rate)
    if taps:
        from skincad.inputs.recordings import film_recording

        if port is None and recorded != "-":
            films = film_recording(recorded or "", detector.ridges)
        else:
            films = _tapped(detector, *_stream(detector, port, recorded, baud, timeout), recording)
        result = skincad.tap_test(films, design.name)
        show(result.as_json(), display.as_json, report(result, verbose=display.verbose))
        leave(result)
    wire, blocks = _stream(detector, port, recorded, baud, timeout)
    console = _Console(listener, f"{source}, {wire.name}")

    def tell(event: dict[str, Any]) -> None:
        console.clear()
        print(json.dumps(event), flush=True)

    if not page:
        listening.listen(wire, blocks, listener, tell, recording, console.update)
        console.update()
        return
    from skincad.live.channels import ChannelsPage

    shown = ChannelsPage(listener, f"{source}, {wire.name}")
    print(f"{shown.address} (Ctrl-C ends it)", file=sys.stderr, flush=True)

    def show_all(block: Block, events: list[dict[str, Any]]) -> None:
        console.update()
        shown.update(block, events)

    try:
        listening.listen(wire, blocks, listener, tell, recording, show_all)
        shown.draw()
        while True:  # a recording is over: it may be looked at
            safe_point()
            sleep(POLL)
    finally:
        shown.close()


def _tapped(
    detector: Detector, wire: Wire, blocks: Iterator[Block], recording: RecordingFile | None
) -> FilmRecording:
    """The recording of a stream while a person taps ridge after ridge, until all were tapped or Ctrl-C."""

    def written() -> Iterator[Block]:
        for block in blocks:
            if recording is not None:
                recording.write(wire, block)
            yield block

    from skincad.detector.taps import hear_taps

    try:
        return hear_taps(detector, written(), lambda text: print(text, file=sys.stderr, flush=True))
    finally:
        if recording is not None:
            recording.close()
            if recording.failure:
                words = f"ends after {recording.samples} samples: {recording.failure}"
                print(f"{recording.path} {words}", file=sys.stderr)


def _stream(
    detector: Detector, port: str | None, recorded: str | None, baud: int, timeout: float | None
) -> tuple[Wire, Iterator[Block]]:
    """The reader and the blocks of a port, of standard input ("-") or of a recording."""
    from skincad.detector import listening

    if timeout is not None and not 0 < timeout < math.inf:
        raise InputError("timeout", "must be above 0 s and finite", timeout)
    if baud < 1:
        raise InputError("baud", "must be at least 1", baud)
    if port is not None:
        limit = listening.TIMEOUT if timeout is None else timeout
        wire = listening.wire_of(detector, port, noisy=True)
        return wire, listening.port_blocks(wire, listening.port_chunks(port, baud, limit))
    if recorded == "-":
        wire = listening.wire_of(detector, "standard input")
        return wire, listening.blocks_of(wire, listening.file_chunks(sys.stdin.fileno(), wire.name, timeout))
    return listening.recording_blocks(detector, Path(recorded or ""))


POLL = 0.1  # s, until Ctrl-C ends a page


class _Console:
    """What a person reads on stderr while a detector listens."""

    def __init__(self, listener: Listener, name: str) -> None:
        self.listener, self.name = listener, name
        self.begun, self.shown = False, 0.0
        self.terminal = sys.stderr.isatty()

    def update(self, *_: object) -> None:
        """Say once what is heard; on a terminal, once a second, how far it has come."""
        listener = self.listener
        if not self.begun and listener.rest is not None:
            self.begun = True
            detector = listener.detector
            rest = ", ".join(
                f"{ridge} {side} {volts:.4g}"
                for (ridge, side), volts in zip(detector.channels, listener.rest, strict=True)
            )
            lines = [
                f"{self.name}: {len(detector.channels)} channels at {detector.rate:g} Hz, a window of "
                f"{detector.tuning.window} samples; at rest, V: {rest}"
            ]
            if not listener.at_rest:
                lines.append(
                    f"What should be rest is {listener.noise:.3g} times as loud as film and amplifier. "
                    "Does something touch the skin? If the board is so loud, give its --noise."
                )
            print(*lines, sep="\n", file=sys.stderr, flush=True)
        if self.terminal and self.begun and listener.seconds - self.shown >= 1:
            self.shown = listener.seconds
            text = f"{listener.seconds:.0f} s, {listener.lost} lost, {listener.alarms} alarms"
            print(f"\r{text}\x1b[K", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Make place for a line on the terminal."""
        if self.terminal and self.shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
