"""Magnets in pins: how they move under the forces on the pins' tips, and the field that sensors under the
skin read of them.

A magnet is a rigid cylinder in its pin, meshed as one in the pin's cell (models/pin_cell.py), and goes too
with the base that other pins push and pull. Its field is that of a uniformly magnetised cylinder, exact at
any distance: a dipole's is off by 1 % up to seven times the magnet's longer side away from its middle, and by
5 % up to three times that. Range: small strain; sensors at rest under a flat back. Left out are the earth's
field, iron nearby, and that magnets push each other, which `push` tells, and a change's error has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.result import Record, item, record, reported
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import NORTH, Magnetometer, Pin
from skincad.shape.skin import skin_of

WAY = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])  # of a pose, without its tilt
VACUUM = 4e-7 * math.pi  # N/A2
# Of a field: neodymium's recoil permeability is 1.05 (makers' tables), and a magnet as long as wide is
# weakened by a third of what is over 1 (Brown, Magnetostatic Principles in Ferromagnetism, 1962)
RECOIL = 0.02
# Of how far a magnet goes and how much it tilts, against CalculiX: six pins near their base's edges, where
# both are more than said
MOVES, TILTS = 0.08, 0.04
TURNS = 16  # points of a half turn round a magnet, times its radius over the way to its nearest point
FEWEST, MOST = 24, 2000
STEP = 1e-4  # mm and rad, of a central difference
RESOLVED = 0.1  # of the mean normal force of a pin, assumption: what is told worse is not told apart
SURE = 1e-9  # of the largest singular value, under which a load makes no reading
WHOLE = 1e-6  # of a force, that may be missing in what sensors see of it


def cylinder_field(places: Array, north: Sequence[float], radius: float, length: float) -> Array:
    """Return the field `(..., 3)` at places `(..., 3)` mm from the middle of a cylinder along z, magnetised
    evenly along `north`, outside of it, in its remanence.

    It is the cylinder's second derivatives of the Newtonian potential: the field of a solenoid (Smythe,
    Static and Dynamic Electricity, 3rd ed., sec. 7.10) along its axis, and across by Laplace's equation. The
    integrals round the axis are sums over equal angles, whose error falls exponentially with their number.
    """
    x, y, z = np.moveaxis(places, -1, 0)
    out = np.hypot(x, y)
    way = np.hypot(np.maximum(out - radius, 0.0), np.maximum(np.abs(z) - length / 2, 0.0))
    nearest = float(way.min(initial=math.inf, where=way > 0))  # inside no number has a meaning
    count = int(np.clip(math.ceil(TURNS * radius / nearest), FEWEST, MOST))
    cosine = np.cos(math.pi * (np.arange(count) + 0.5) / count)
    flat = radius**2 + (out**2)[..., None] - 2 * radius * out[..., None] * cosine
    share, rise = 0.0, 0.0  # of both ends: the way along over the distance, and one over the distance
    for end, sign in ((length / 2, 1.0), (-length / 2, -1.0)):
        along = (z + end)[..., None]
        away = np.sqrt(along**2 + flat)
        share, rise = share + sign * along / away, rise + sign / away
    half = radius / 2 / count  # of a sum over half a turn, a mean times radius / 2
    up_up = half * ((radius - out[..., None] * cosine) / flat * share).sum(axis=-1)
    out_up = -half * (cosine * rise).sum(axis=-1)
    around = -half * radius * ((1 - cosine**2) / flat * share).sum(axis=-1)
    axis = out == 0.0
    cos, sin = (np.where(axis, on, part) / np.where(axis, 1.0, out) for part, on in ((x, 1.0), (y, 0.0)))
    along_out, along_round = north[0] * cos + north[1] * sin, north[1] * cos - north[0] * sin
    radial = -(up_up + around) * along_out + out_up * north[2]
    return np.stack(
        [
            radial * cos - around * along_round * sin,
            radial * sin + around * along_round * cos,
            out_up * along_out + up_up * north[2],
        ],
        axis=-1,
    )


@dataclass(frozen=True, eq=False)
class MagneticPins:
    """Pins with magnets, and the sensors under them: `middle` `(n, 3)` mm of the magnets at rest and
    `place` `(s, 3)` mm of the sensors, both from the middle of the flat back; `goes` `(n, 6, n, 3)` by how
    much magnets go and turn under forces on all tips; a magnet's `north`, `radius` and `length` mm, and
    `remanence` mT, with its relative `spread`."""

    middle: Array
    place: Array
    goes: Array
    north: tuple[float, float, float]
    radius: float
    length: float
    remanence: float
    spread: float

    def poses(self, forces: Array) -> Array:
        """Return how magnets go, mm, and turn, rad, `(n, 6)` under forces on the tips `(n, 3)` N."""
        return np.asarray(np.einsum("ncmd,md->nc", self.goes, forces))

    def fields(self, poses: Array, places: Array | None = None) -> Array:
        """Return the field of each magnet at each place, the sensors' if None, `(places, n, 3)` mT."""
        from scipy.spatial.transform import Rotation

        places = self.place if places is None else places
        turn = Rotation.from_rotvec(poses[:, 3:]).as_matrix()
        way = places[:, None] - self.middle - poses[:, :3]
        inside = np.einsum("nji,snj->sni", turn, way)
        field = cylinder_field(inside, self.north, self.radius, self.length)
        return np.asarray(self.remanence * np.einsum("nij,snj->sni", turn, field))

    def slope(self, poses: Array) -> Array:
        """Return how the sensors' fields rise with the forces on the tips, `(3 s, 3 n)` mT/N."""
        steps = np.eye(6) * STEP
        by_pose = np.stack(
            [(self.fields(poses + s) - self.fields(poses - s)) / (2 * STEP) for s in steps], axis=-1
        )
        rise = np.einsum("snic,ncmd->simd", by_pose, self.goes)
        return np.asarray(rise.reshape(3 * len(self.place), -1))

    def uncertain(self, poses: Array) -> Array:
        """Return what each magnet's way, tilt and remanence may be off in the sensors' fields `(3 s, 3 n)`
        mT."""
        rest, way, both = (self.fields(poses * part) for part in (0.0, WAY, 1.0))
        parts = MOVES * (way - rest), TILTS * (both - way), (self.spread + RECOIL) * (both - rest)
        return np.moveaxis(np.concatenate(parts, axis=1), 2, 1).reshape(3 * len(rest), -1)

    def push(self) -> Array:
        """Return the forces of the magnets on each other `(n, n, 3)` N, of the second on the first, which is
        taken as a dipole in the second's field."""
        moment = self.remanence * math.pi * self.radius**2 * self.length / VACUUM * 1e-12  # A m2
        still, many = np.zeros((len(self.middle), 6)), np.arange(len(self.middle))
        along = np.array(self.north) @ np.stack(
            [
                (self.fields(still, self.middle + s) - self.fields(still, self.middle - s)) / (2 * STEP)
                for s in np.eye(3) * STEP
            ]
        ).transpose(1, 2, 3, 0)  # mT/mm
        along[many, many] = 0.0
        return np.asarray(moment * along)


@lru_cache(maxsize=8)
def magnetic_pins(design: Design) -> MagneticPins:
    """Return the pins with magnets of a design with sensors, in small strain. Raises ValueError for one
    without."""
    from skincad.mechanics.models import reduced

    pocket, sensors = design.of(Pin).pocket, design.magnetometer
    if pocket is None or pocket.magnet is None or sensors is None:
        raise ValueError(f"{design.name} has no magnets that sensors read")
    magnet, low, high = pocket.magnet, *pocket.magnet.range
    under = np.array([placed.tip[:2] for placed in skin_of(design).placed])
    middle = np.column_stack([under, np.full(len(under), sum(pocket.magnet_span) / 2)])
    below = np.column_stack([under, np.full(len(under), sensors.below or 0.0)])
    with one_blas_thread():
        goes = reduced.magnet_compliance(design, reduced.pin_cells(design))
    return MagneticPins(
        middle=middle,
        place=(np.array(sensors.places) if sensors.places else below) * [1.0, 1.0, -1.0],
        goes=goes,
        north=NORTH[magnet.north],
        radius=magnet.diameter / 2,
        length=magnet.length,
        remanence=1000 * (low + high) / 2,
        spread=(high - low) / (high + low),
    )


@record()
class SensorReading(Record):
    """What a sensor reads along x, y and z, of all magnets."""

    place: tuple[float, float, float] = item("mm", "x, y and z from the middle of the flat back")
    rest: tuple[Estimate, ...] = item("mT", "without a load")
    change: tuple[Estimate, ...] = item("mT", "by the press")

    @property
    def largest(self) -> float:
        """The largest field of an axis, mT, without a load or with it."""
        return max(
            max(abs(a.value or 0.0), abs((a.value or 0.0) + (b.value or 0.0)))
            for a, b in zip(self.rest, self.change, strict=True)
        )


@record()
class PinSignal(Record):
    """How a pin's magnet goes under the press, and the forces on its tip that sensors tell from noise."""

    place: tuple[float, float, float] = item("mm", "of its magnet's middle without a load, as a sensor's")
    displacement: tuple[float, ...] = item("mm", "of that by the press")
    tilt: float = item("deg", "of its magnet")
    alone: tuple[float, ...] = item("N", "along x, y and z whose reading is as large as the noise rms")
    floor: tuple[float | None, ...] = item(
        "N", "rms noise of the forces that the readings give where all pins' are unknown; null: not given"
    )

    @property
    def moved(self) -> float:
        """How far its magnet goes, mm."""
        return math.hypot(*self.displacement)


@record()
class MagnetSignal(Record):
    """The sensors' readings of a press, and what forces they tell."""

    sensors: tuple[SensorReading, ...] = item(meaning="of each sensor")
    pins: tuple[PinSignal, ...] = item(meaning="of each pin")
    noise: float = item("uT", "rms of a sample, with its rounding")
    band: float = item("Hz", "up to which that holds")
    range: float = item("mT", "of a sensor's axis")
    condition: float | None = item(
        meaning="largest over smallest singular value of the map from forces to readings; null: some forces "
        "make no reading"
    )
    threshold: float = item("N", "a tenth of the mean force on a pin: forces with less noise are told apart")
    push: float = item("N", "largest sum of other magnets' forces on one, without a load; not counted")
    push_change: float = item(meaning="relative error of changes by that")
    map_error: float = item(
        meaning="relative, of how readings rise with a force, the largest: what a way and a tilt do may "
        "nearly cancel"
    )

    @reported(meaning="components of forces, three a pin, that are told apart from all others")
    def resolved(self) -> int:
        """How many components of the pins' forces have noise of less than `threshold`."""
        return sum(f is not None and f <= self.threshold for pin in self.pins for f in pin.floor)

    @property
    def largest(self) -> float:
        """The largest field of a sensor's axis, mT, without a load or with it."""
        return max(sensor.largest for sensor in self.sensors)

    @property
    def largest_change(self) -> Estimate:
        """The largest change of a sensor's axis."""
        changes = (change for sensor in self.sensors for change in sensor.change)
        return max(changes, key=lambda change: abs(change.value or 0.0))

    @property
    def floors(self) -> list[float]:
        """The noise of all components of forces that the readings give, N."""
        return [floor for pin in self.pins for floor in pin.floor if floor is not None]

    @reported("N", "largest noise of a component; null: the readings do not give one")
    def largest_floor(self) -> float | None:
        """The largest noise of a component of forces, N; None where the readings do not give one."""
        return max(self.floors) if len(self.floors) == 3 * len(self.pins) else None

    @reported(meaning="how many sensors leave their range, at rest or under the press")
    def saturated(self) -> int:
        """How many sensors leave their range."""
        return sum(sensor.largest > self.range for sensor in self.sensors)


def magnet_signal(design: Design, pressed: Sequence[Estimate]) -> MagnetSignal | None:
    """Return what a design's sensors read of a press with these forces on its pins, N; None without sensors.

    The field is that of the magnets where the forces have put them. A change's error is the remanence's, the
    model's, and that of all forces, which are taken as independent.
    """
    sensors = design.magnetometer
    if sensors is None:
        return None
    pins, loads = magnetic_pins(design), np.array([force.value or 0.0 for force in pressed])
    poses = pins.poses(np.outer(loads, [0.0, 0.0, -1.0]))
    rest = pins.fields(0 * poses).sum(axis=1)
    change, slope = pins.fields(poses).sum(axis=1) - rest, pins.slope(poses)
    by_way = pins.fields(poses * WAY).sum(axis=1) - rest  # which a tilt may take away again
    moved = MOVES * np.abs(by_way) + TILTS * np.abs(change - by_way)
    level = replace(pins, goes=pins.goes * WAY[:, None, None]).slope(poses)
    way, tilt, both = (np.linalg.norm(of, axis=0) for of in (level, slope - level, slope))
    push = np.linalg.norm(pins.push(), axis=2).sum(axis=1).max(initial=0.0)
    # two side by side push by the fourth power of their distance; a pin gives way to that as to its own load
    spring = 4 * push / design.spacing * float(pins.goes[:, :2, :, :2].max())
    by_forces = np.hypot.reduce(slope[:, 2::3] * [force.error or 0.0 for force in pressed], axis=1)
    sure = pins.spread + RECOIL
    error = np.abs(change) * (sure + spring) + moved + by_forces.reshape(change.shape)
    within = np.maximum(np.abs(rest), np.abs(rest + change)).max(axis=1) <= sensors.range
    floor, alone, condition = force_noise(slope, sensors, within)
    readings, signals = (
        zip(*(of.tolist() for of in rows), strict=True)
        for rows in ((pins.place, rest, change, error), (pins.middle, poses, alone, floor))
    )
    return MagnetSignal(
        sensors=tuple(
            SensorReading(
                place=tuple(place),
                rest=tuple(Estimate(b, sure * abs(b), "mT") for b in at_rest),
                change=tuple(Estimate(b, e, "mT") for b, e in zip(by, errors, strict=True)),
            )
            for place, at_rest, by, errors in readings
        ),
        pins=tuple(
            PinSignal(
                place=tuple(at),
                displacement=tuple(pose[:3]),
                tilt=math.degrees(math.hypot(*pose[3:])),
                alone=tuple(one),
                floor=tuple(None if math.isinf(f) else f for f in joint),
            )
            for at, pose, one, joint in signals
        ),
        noise=1000 * sensors.rms,
        band=sensors.rate / 2,
        range=sensors.range,
        condition=condition,
        threshold=RESOLVED * float(loads.mean()),
        push=push,
        push_change=spring,
        map_error=sure + spring + float(((MOVES * way + TILTS * tilt) / both).max()),
    )


def force_noise(slope: Array, sensors: Magnetometer, within: Mask) -> tuple[Array, Array, float | None]:
    """Return the noise of forces `(n, 3)` N by a map of forces to readings `(3 s, 3 n)` mT/N: of those that
    least squares give of the readings of all sensors `within` `(s,)` their range; of each if it is the only
    one, by all sensors; infinite where readings don't give it. And the condition number of the map to those
    within, None of one that is not of full rank."""
    alone = sensors.rms / np.maximum(np.linalg.norm(slope, axis=0), 1e-300)
    with one_blas_thread():
        _, values, rows = np.linalg.svd(slope * np.repeat(within, 3)[:, None], full_matrices=False)
    seen = values > SURE * values[0]
    variance = ((rows[seen] / values[seen, None]) ** 2).sum(axis=0)
    whole = (rows[seen] ** 2).sum(axis=0) > 1 - WHOLE
    joint = np.where(whole, sensors.rms * np.sqrt(variance), math.inf)
    full = bool(seen.all()) and slope.shape[0] >= slope.shape[1]
    return joint.reshape(-1, 3), alone.reshape(-1, 3), float(values[0] / values[-1]) if full else None
