"""Scenes: the march through a history, its signals, when ridges slip, and what is left out."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    alarms: NOTHING NOT_AHEAD PASSING Score report score
    carrying: Carried Carrier PressedSkin carrier
    ears: Ears rate_of
    errors: BySource Slips intervals near_chosen slip_errors slips_of
    grip: Force Grip followed
    lift: Lift LiftRun carried
    march: GROSS_SLIP LEVELS Level March expected frames
    plan: IN_CHOSEN_STEPS DEFAULT_TOLERANCE FREE_ENDS SMALL_STRAIN chosen_steps folds
        held_against_rounder left_out_effects path_of with_rounder_fillets
    runs: MarchSetup Runs coarse_steps differential halts_of march_on marches_masses piece_for
    scene: History LAW Readout Scene ScenePlate load_scene
    simulation: SceneRun Simulation at_level energy friction_cone marched marching read_out shown_signal
        simulate
    """,
)
