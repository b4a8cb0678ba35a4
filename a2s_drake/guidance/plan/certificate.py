"""Whether the vehicle can fly an attitude: every limit on a finer grid, by means that the planner does not use.

Rates and accelerations are finite differences of where the vehicle is; torque and force are Drake's own inverse
dynamics of the MultibodyPlant that is simulated.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from scipy.spatial.transform import Rotation

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.airframe import make_plant, wrench_map

# Half-width of the finite differences, s: at a knot, where the torque has a kink, they are wrong by a hundredth of a
# rad/s^2; in between by rounding alone, some 1e-8 rad/s^2.
_HALF_WIDTH = 1e-4
# How closely a plan must start level and start and end at rest, rad and rad/s.
_REST_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Certificate:
    """The extremes of a plan over a fine grid, beside the vehicle's own limits, without any margin."""

    samples: int
    # Lowest and highest rotor speed, Hz, and the airframe's.
    rotor_speed_min: float
    rotor_speed_max: float
    rotor_speed_range: tuple[float, float]
    # Largest Euler angle, deg, and body angular velocity, rad/s, on any axis, and the controller's limits.
    attitude_max_deg: float
    attitude_limit_deg: float
    angular_velocity_max: float
    angular_velocity_limit: float
    # Largest of: attitude (rad) and rate (rad/s) at 0, rate at the end.
    rest_error: float

    @property
    def margins(self) -> dict[str, float]:
        """What is left of each limit, negative where it is broken: a share of the range of thrust, or of the limit."""
        low, high, lowest, highest = (
            np.copysign(speed**2, speed)
            for speed in (*self.rotor_speed_range, self.rotor_speed_min, self.rotor_speed_max)
        )
        return {
            "rotor_speed_min": float((lowest - low) / (high - low)),
            "rotor_speed_max": float((high - highest) / (high - low)),
            "attitude": 1.0 - self.attitude_max_deg / self.attitude_limit_deg,
            "angular_velocity": 1.0 - self.angular_velocity_max / self.angular_velocity_limit,
        }

    @property
    def holds(self) -> bool:
        """Whether every limit is kept, and the plan starts level and starts and ends at rest."""
        return not self.broken

    @property
    def broken(self) -> str:
        """What is broken and by how much, in words; an empty text where nothing is."""
        # A margin that is not a number counts as broken.
        parts = [f"{name} by {-100.0 * left:.2g} %" for name, left in self.margins.items() if not left >= 0.0]
        if not self.rest_error <= _REST_TOLERANCE:
            parts.append(f"rest at the start or the end by {self.rest_error:.2g}")
        return ", ".join(parts)


def certify(spline: AttitudeSpline, scenario: Scenario, samples_per_second: float) -> Certificate:
    """Checks an attitude flown along the planned path, from take-off through its end to the rest after it."""
    duration = spline.duration
    count = int(np.ceil(duration * samples_per_second)) + 1
    # At both ends accelerations may jump, and no difference may reach across. The last instant is well after the end.
    time = np.append(np.linspace(_HALF_WIDTH, duration - _HALF_WIDTH, count), duration + 1.0)
    u = _inputs(spline, scenario, time)
    eta, omega = spline.eta(time), _angular_velocity(spline, time)
    ends = spline.rate(np.array([0.0, duration]))
    return Certificate(
        samples=time.size,
        # A rotor asked to push downwards is as far outside as one that turns as fast the wrong way.
        rotor_speed_min=float((np.sign(u) * np.sqrt(np.abs(u))).min()),
        rotor_speed_max=float(np.sqrt(np.abs(u).max())),
        rotor_speed_range=(scenario.airframe.rotor_speed_min, scenario.airframe.rotor_speed_max),
        attitude_max_deg=float(np.degrees(np.abs(eta).max())),
        attitude_limit_deg=scenario.mpc.attitude_limit_deg,
        angular_velocity_max=float(np.abs(omega).max()),
        angular_velocity_limit=scenario.mpc.angular_velocity_limit,
        rest_error=float(max(np.abs(spline.eta(np.zeros(1))).max(), np.abs(ends).max())),
    )


def _turned(spline: AttitudeSpline, time: FloatArray) -> Rotation:
    return Rotation.from_euler("ZYX", spline.eta(time)[:, ::-1])


def _angular_velocity(spline: AttitudeSpline, time: FloatArray) -> FloatArray:
    """Body angular velocity, rad/s, B, shape (n, 3)."""
    before, after = _turned(spline, time - _HALF_WIDTH), _turned(spline, time + _HALF_WIDTH)
    return np.asarray((before.inv() * after).as_rotvec() / (2.0 * _HALF_WIDTH))


def _inputs(spline: AttitudeSpline, scenario: Scenario, time: FloatArray) -> FloatArray:
    """Squared rotor speeds, Hz^2, shape (n, 6)."""
    times = (time - _HALF_WIDTH, time, time + _HALF_WIDTH)
    p_before, p, p_after = (uav_path(scenario.mission).position(instant) for instant in times)
    R_before, R_WB, R_after = (_turned(spline, instant) for instant in times)
    w_early, w_late = ((b * a.inv()).as_rotvec() / _HALF_WIDTH for a, b in ((R_before, R_WB), (R_WB, R_after)))
    velocity = np.hstack([(w_early + w_late) / 2.0, (p_after - p_before) / (2.0 * _HALF_WIDTH)])
    acceleration = np.hstack([w_late - w_early, (p_after - 2.0 * p + p_before) / _HALF_WIDTH]) / _HALF_WIDTH

    plant, _ = make_plant(scenario.airframe)
    quaternion = np.roll(R_WB.as_quat(), 1, axis=1)  # SciPy writes the scalar part last, Drake first.
    wrench_W = _inverse_dynamics(plant, np.hstack([quaternion, p]), velocity, acceleration)
    wrench_B = np.hstack([R_WB.inv().apply(wrench_W[:, 3:]), R_WB.inv().apply(wrench_W[:, :3])])
    return np.asarray(np.linalg.solve(wrench_map(scenario.airframe), wrench_B.T).T)


def _inverse_dynamics(plant: MultibodyPlant, q: FloatArray, v: FloatArray, vdot: FloatArray) -> FloatArray:
    """Torque (N m) over force (N) on the body, W, shape (n, 6), that moves a plant as given."""
    context, gravity = plant.CreateDefaultContext(), MultibodyForces(plant)
    wrench = np.empty_like(v)
    for row in range(len(q)):
        plant.SetPositions(context, q[row])
        plant.SetVelocities(context, v[row])
        plant.CalcForceElementsContribution(context, gravity)
        wrench[row] = plant.CalcInverseDynamics(context, vdot[row], gravity)
    return wrench
