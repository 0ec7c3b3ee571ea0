"""The film and its amplifier: network, gain by frequency, calibration, response in time, noise; in SI."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    boards: Board BoardPart INPUTS board
    bode: COLUMNS CircuitGain film_load gain told_rig without_rig
    calibrate: BOUNDS FITTED PAPER_ABOVE PAPER_BELOW PAPER_CUTOFF PAPER_HIGH PAPER_LOW
    model: Circuit circuit_network constants fitted load_circuit output_offset output_swing
    network: Complex Constants Network PICO Real capacitance charge electrode netlist
    rails: at_rails
    response: decibels noise_samples tells_stress total_density
    state: FilteredSignal PASS Recording Stepper band_limited corner delay evenly_spaced longest_step
        recorded rms_behind run state_space stepper
    """,
)
