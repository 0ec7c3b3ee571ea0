"""From a wish to a design: the value that gives it, and many designs side by side.

A study asks one question (a check, a make, a simulation or a gain) of one subject (a design, a scene or a
circuit) at many values of its keys.
"""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    accuracy.accuracy: Accuracy
    accuracy.contact: MESH measures_of
    accuracy.ladder: ErrorMeasure Ladder Measurement slope
    accuracy.slip: scene_on
    advice: advise advising seconds_for_advice
    holding: AMPLIFIER FIRST FRICTION KINDS LiftOutcome RISE drawn_lift hears history holding_of
        lift_signal lifted mass_of scene_of summed
    optimising: optimise
    query: Evaluation Query evaluate first_able short worded
    running: Log
    searches: combinations
    solving: Solution SolutionPoint solve
    study: Member Optimisation Study load_study
    subject: ALL CIRCUIT DesignVariable SKIN Setting Value changed kinds knob knobs load_subject owner
        texts value_of
    sweeping: Ranking SweepResult model_error points_of sweep
    wish: USUAL_FILM USUAL_PROCESS USUAL_TOUCH WishResult design_for film_of force_of meets room size_of
        thickness_of
    wish_shapes: FILM_ROOM LEAST_RIDGES SLOT SLOT_SHARE WIRE_SLIT
    """,
)
