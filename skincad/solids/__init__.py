"""Solids of skin, mold and inserts: plans as data, built by the CAD kernel in `occ.py`."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    bent: gap_beside
    bone: Bone bone_of least_over pinned
    cavity: SAFE_SHARE parts_at_tips safe_strain split_ridges
    coupon: BAR BARS HEIGHTS NOTCHES NOTCH_DEPTH NOTCH_PITCH REPEATS coupon_parts
        drawn_notches drawn_steps poured_volumes
    fasteners: BlindThread HEAD LENGTHS METRIC RUN_OUT TAP_RADIUS WASHER blind_thread insert_outer
        insert_radius run_out_room screw_for standard_length torque
    gate: GRAVITY LUER SYRINGES THUMB TIPS TIP_LENGTH TIP_PLAY WIDTHS filling_time press tip
    inserts: BEND GRIP MOST_TURN PIN_RADIUS STUB fan_lead fan_offset lead_length
        strip_overhangs
    layout: Fits Layout MOST_BOW SEAL_PLAY SHEETS SQUEEZED_SHARE STOCK bow end_angle fits
        is_clamped lid_process stack_error thick_enough
    mold: ClosedMold Move mold_solids
    occ: KernelError given_solid moments solid tessellate triangles unchecked_solid volume workplane
    pins: hole_block pockets
    plan: Axis Body Bore CAVITIES CutRole END_PLATES ExtendedCut GivenBody Grid PINS Part PartRole Prism
        RevolvedBody RotatedBody TurnedBody Vector bores box corners mirrored plain shifted turn_steps
        unturned
    projection: Arc Place Polyline Projection Stroke View extent outlined
    shots: behind bond_of room
    shrinkage: scaled_for_shrinkage
    skin: Way along_skin skin_part skin_solid swept
    split: notch_rise
    """,
)
