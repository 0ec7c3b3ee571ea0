"""What hears a slip in the films' outputs, and the tap test of its channels."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    detector: AHEAD Alarm BACK Detector EARLY GRIP GRIPPER INCIPIENT POINTS RIDGES SEEN SKIN SURE Tuning
        Weights change_noise taken tuned weights
    listening: Listener listen port_blocks port_chunks wire_of
    taps: TapTest tap_test
    wire: Block Wire
    """,
)
