"""The sections of a scenario: every number that a run depends on, with unit, source and allowed range.

The defaults are Table I of the paper (M. Bajja et al., "3D Euler-Angle Orientation Control for Two-Ray Fading
Mitigation in Maritime Air-to-Sea Communications", IEEE GLOBECOM 2026). Where the paper gives no value, the default is a
public constant of its airframe family. Units are SI; angles that a person types are in degrees, and their names say so.
"""

import math
from dataclasses import dataclass, field
from typing import Any

GRAVITY = 9.81  # Drake's default, m/s^2.

PAPER_LAWS = ("three_axis", "pitch_only", "level")  # the paper's
LAW_NAMES = (*PAPER_LAWS, "planned")
FALLBACKS = ("nearest", "zero", "index_zero")
SOLVERS = ("piqp", "osqp", "ipopt")
INTEGRATORS = ("runge_kutta2", "runge_kutta3", "runge_kutta5", "explicit_euler")


def _number(default: float | int | None, **limits: Any) -> Any:
    """A scalar field; `limits` are read by `a2s_drake.scenario.checks` (above, at_least, below, at_most, choices)."""
    return field(default=default, metadata=limits)


def _vector(*default: float, **limits: Any) -> Any:
    """A list field of the length of its default; `limits` hold for every entry."""
    return field(default_factory=lambda: list(default), metadata={"length": len(default), **limits})


def _choice(default: str, choices: tuple[str, ...]) -> Any:
    return field(default=default, metadata={"choices": choices})


def _file() -> Any:
    """A field that may name a file; in a scenario file a relative name is relative to that file's folder."""
    return field(default=None, metadata={"file": True})


@dataclass
class Airframe:
    """The tilted hexarotor: a rigid body with six rotors at 60 deg spacing, the first on the body's +x axis."""

    # Mass, kg (Table I).
    mass: float = _number(2.57, at_least=1e-3, at_most=1e4)
    # Principal moments of inertia about the body axes, kg m^2 (Table I).
    inertia: list[float] = _vector(0.11, 0.11, 0.19, at_least=1e-6, at_most=1e5)
    # Distance of each rotor hub from the centre of mass, m (public constant of the airframe family).
    arm_length: float = _number(0.38998, at_least=1e-3, at_most=100.0)
    # Tilt of each thrust axis about its own arm, alternating in sign from rotor to rotor, deg (same).
    tilt_deg: float = _number(20.0, at_least=0.0, below=90.0)
    # Thrust per squared rotor speed, N/Hz^2 (same).
    thrust_coefficient: float = _number(11.75e-4, at_least=1e-9, at_most=1e3)
    # Rotor drag torque per thrust, m (same).
    drag_to_thrust: float = _number(0.0203, at_least=0.0, at_most=10.0)
    # -1: the drag torque opposes the yaw moment that the tilt makes; +1: it adds to it. A reading, not in the paper.
    drag_sign: int = _number(-1, choices=(-1, 1))
    # Lowest and highest rotor speed, Hz (Table I).
    rotor_speed_min: float = _number(16.0, at_least=0.0, at_most=1e4)
    rotor_speed_max: float = _number(100.0, above=0.0, at_most=1e4)


@dataclass
class Link:
    """The two-ray radio link: carrier, sea reflection, both antennas and the power budget."""

    # Carrier frequency, Hz (Table I).
    carrier_hz: float = _number(3.0e9, at_least=1e6, at_most=1e12)
    # Speed of light, m/s (SI). The paper's own wavelength of about 10 cm suggests 3e8.
    speed_of_light: float = _number(299792458.0, at_least=1e8, at_most=1e9)
    # Magnitude gamma of the sea's reflection coefficient (Table I); its phase is pi.
    reflection_magnitude: float = _number(0.8, at_least=0.0, at_most=1.0)
    # Antenna phase centre in the body frame, m (Table I).
    antenna_offset: list[float] = _vector(0.39, 0.39, 0.195, at_least=-100.0, at_most=100.0)
    # Height of the ship's antenna above the sea, m (Table I).
    ship_antenna_height: float = _number(10.0, above=0.0, at_most=1e4)
    # Transmit power, dBm (Table I).
    transmit_power_dbm: float = _number(10.0, at_least=-300.0, at_most=300.0)
    # Noise power, dBm (Table I).
    noise_power_dbm: float = _number(-80.0, at_least=-300.0, at_most=300.0)

    @property
    def wavelength(self) -> float:
        """Carrier wavelength, m."""
        return self.speed_of_light / self.carrier_hz

    @property
    def transmit_to_noise(self) -> float:
        """P_t / sigma^2, dimensionless: the SNR of a channel of unit gain."""
        return float(10.0 ** ((self.transmit_power_dbm - self.noise_power_dbm) / 10.0))


@dataclass
class Mission:
    """Where UAV and ship go: the UAV once around a circle, the ship along a straight line; then both stand still.

    A file may take the place of the circle, and another one that of the line.
    """

    # Duration T of the manoeuvre, s (Table I).
    duration: float = _number(40.0, at_least=1e-3, at_most=86400.0)
    # Radius of the UAV's circle, m (Table I).
    radius: float = _number(2.65, at_least=0.0, at_most=1e4)
    # First point of the circle, m, world frame; its centre lies one radius towards -x (section V of the paper).
    start: list[float] = _vector(0.0, 0.0, 0.0, at_least=-1e5, at_most=1e5)
    # Height of the sea surface in the world frame, m (section II of the paper).
    sea_level: float = _number(-20.0, at_least=-1e5, at_most=1e5)
    # First and last horizontal position (x, y) of the ship, m, world frame (Table I).
    ship_start: list[float] = _vector(90.0, 0.0, at_least=-1e6, at_most=1e6)
    ship_end: list[float] = _vector(100.0, 0.0, at_least=-1e6, at_most=1e6)
    # CSV file with columns time,x,y,z (s, m, world frame) of a path that the UAV flies in place of the circle; `radius`
    # and `start` are then not used. The vehicle starts at rest where the path begins. A relative name in a scenario
    # file is relative to that file's folder.
    path_file: str | None = _file()
    # CSV file with columns time,x,y (s, m, world frame) of a track that the ship sails in place of the line;
    # `ship_start` and `ship_end` are then not used.
    ship_track_file: str | None = _file()


@dataclass
class AttitudeLaw:
    """The attitude reference: which law, and the readings that the paper leaves open."""

    # three_axis: the paper's proposal; pitch_only and level: its two benchmarks; planned: see `Planning`.
    name: str = _choice("three_axis", LAW_NAMES)
    # Half-width of the Euler-angle box that makes a candidate feasible (the set M_f), deg.
    candidate_limit_deg: float = _number(15.0, at_least=1e-3, at_most=180.0)
    # What to do where no candidate is feasible; see `a2s_drake.guidance.soft_min`.
    fallback: str = _choice("nearest", FALLBACKS)
    # Soft-min temperature tau, 1/rad^2 (Table I).
    temperature: float = _number(7.0, at_least=1e-6, at_most=1e6)
    # First and last fringe index of the candidate set M (Table I).
    index_min: int = _number(-50, at_least=-100_000, at_most=100_000)
    index_max: int = _number(50, at_least=-100_000, at_most=100_000)

    @property
    def candidate_limit(self) -> float:
        """Half-width of the candidate box, rad."""
        return math.radians(self.candidate_limit_deg)


@dataclass
class Planning:
    """How the law `planned` makes its plan before take-off, and how far the plan stays inside the vehicle's limits."""

    # Spacing of the spline's knots, s, and largest spacing of the instants at which the limits are imposed, s.
    knot_spacing: float = _number(0.1, at_least=1e-2, at_most=10.0)
    limit_spacing: float = _number(0.025, at_least=1e-3, at_most=10.0)
    # How far the plan stays from the lowest and from the highest rotor speed, Hz, and from the largest Euler angle and
    # the largest body angular velocity, as a share of these. The rest is left to the controller, which follows an
    # undisturbed plan to 0.05 deg.
    rotor_speed_min_margin: float = _number(0.5, at_least=0.0, at_most=1e4)
    rotor_speed_max_margin: float = _number(0.5, at_least=0.0, at_most=1e4)
    attitude_margin: float = _number(0.005, at_least=0.0, below=1.0)
    angular_velocity_margin: float = _number(0.01, at_least=0.0, below=1.0)
    # Penalty on the square of the Euler angles' acceleration over time, bit/Hz per rad^2/s^3. It makes the plan smooth
    # where the link does not care, and costs less than 0.03 % of the throughput.
    acceleration_weight: float = _number(1.0e-4, at_least=0.0, at_most=1e3)
    # Length of a stage of the dynamic programme that chooses the fringes, s, and the most grid steps by which an Euler
    # angle may change in one stage.
    search_period: float = _number(0.05, at_least=1e-2, at_most=10.0)
    search_reach: int = _number(2, at_least=1, at_most=5)
    # Most iterations of the sequential quadratic programme, and of IPOPT, which improves its answer; 0 leaves it out.
    sqp_iterations: int = _number(80, at_least=0, at_most=100_000)
    ipopt_iterations: int = _number(20, at_least=0, at_most=100_000)
    # Number of instants per second at which a finished plan is checked, 1/s.
    certificate_rate: float = _number(200.0, at_least=1.0, at_most=1e5)


@dataclass
class Mpc:
    """The tracking controller: horizon, weights, bounds and solver."""

    # piqp, osqp: one Gauss-Newton QP a sample (real-time iteration). PIQP keeps its workspace between samples; OSQP is
    # Drake's own. ipopt: the whole nonlinear program a sample.
    solver: str = _choice("piqp", SOLVERS)
    # Sampling period T_s, s, and number N of periods in the horizon (Table I).
    period: float = _number(0.02, at_least=1e-4, at_most=10.0)
    horizon: int = _number(30, at_least=1, at_most=1000)
    # Stage and terminal weights, each times the identity (Table I). The paper prints Q_p,N = Q_p and Q_eta,N = Q_eta
    # and is silent on the other two terminal weights; they equal their stage weights here.
    position_weight: float = _number(100.0, at_least=1e-9, at_most=1e9)  # 1/m^2
    attitude_weight: float = _number(50.0, at_least=1e-9, at_most=1e9)  # 1/rad^2
    velocity_weight: float = _number(1.0, at_least=0.0, at_most=1e9)  # s^2/m^2
    angular_velocity_weight: float = _number(10.0, at_least=0.0, at_most=1e9)  # s^2/rad^2
    input_weight: float = _number(3.2e-8, at_least=0.0, at_most=1.0)  # 1/Hz^4
    # The paper's cost weighs velocity, angular velocity and input against zero. `true`: where the law plans them too
    # (planned), they are weighed against the plan instead.
    feedforward: bool = field(default=True, metadata={"choices": (False, True)})
    # Largest magnitude on each axis: Euler angle, deg; velocity, m/s; body angular velocity, rad/s (Table I).
    attitude_limit_deg: float = _number(15.0, at_least=1e-3, below=90.0)
    velocity_limit: float = _number(1.0, at_least=1e-3, at_most=1e3)
    angular_velocity_limit: float = _number(1.0, at_least=1e-3, at_most=1e3)
    # Corners of the operating region A, m, world frame (not given in the paper).
    position_lower: list[float] = _vector(-10.0, -10.0, -10.0, at_least=-1e5, at_most=1e5)
    position_upper: list[float] = _vector(10.0, 10.0, 10.0, at_least=-1e5, at_most=1e5)
    # Absolute and relative tolerance of the QP, and its iteration limit (of which piqp uses at most 40).
    qp_tolerance: float = _number(1e-5, at_least=1e-12, at_most=0.1)
    qp_max_iterations: int = _number(4000, at_least=1, at_most=1_000_000)

    @property
    def attitude_limit(self) -> float:
        """Largest magnitude of each Euler angle, rad."""
        return math.radians(self.attitude_limit_deg)


@dataclass
class Simulation:
    """How the continuous plant is integrated between the controller's samples, and for how long."""

    # Length of the flight, s; null means the mission's duration.
    duration: float | None = _number(None, at_least=1e-4, at_most=86400.0)
    # Drake's name of the fixed-step integration scheme.
    integrator: str = _choice("runge_kutta3", INTEGRATORS)
    # Largest integration step, s.
    max_step_size: float = _number(0.01, at_least=1e-6, at_most=1.0)


@dataclass
class Disturbance:
    """Disturbances of the vehicle that the controller is not told of; by default there are none."""

    # Peak force of a gust on the centre of mass, N, world frame; it swells and dies as (1 - cos)/2, the standard shape
    # of a discrete gust (MIL-F-8785C).
    gust_force: list[float] = _vector(0.0, 0.0, 0.0, at_least=-1e4, at_most=1e4)
    # Length of a gust, s, and time from the start of one to the start of the next, s; the first starts after one.
    gust_duration: float = _number(1.5, at_least=1e-3, at_most=86400.0)
    gust_interval: float = _number(5.0, at_least=1e-3, at_most=86400.0)
    # The vehicle's true mass and inertia over those of `airframe`.
    mass_factor: float = _number(1.0, at_least=0.01, at_most=100.0)
    inertia_factor: float = _number(1.0, at_least=0.01, at_most=100.0)
    # The share of the commanded thrust and drag that each rotor gives.
    rotor_efficiency: list[float] = _vector(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, at_least=0.0, at_most=10.0)
    # Standard deviation of white noise on each axis of the measured position, m, attitude, deg, velocity, m/s, and
    # angular velocity, rad/s, and the seed that it is drawn from.
    position_noise: float = _number(0.0, at_least=0.0, at_most=1e3)
    attitude_noise_deg: float = _number(0.0, at_least=0.0, at_most=180.0)
    velocity_noise: float = _number(0.0, at_least=0.0, at_most=1e3)
    angular_velocity_noise: float = _number(0.0, at_least=0.0, at_most=1e3)
    noise_seed: int = _number(0, at_least=0, at_most=2**31 - 1)
    # Whole controller periods that pass before a command reaches the rotors.
    input_delay_periods: int = _number(0, at_least=0, at_most=100)

    @property
    def noise_deviations(self) -> list[float]:
        """Standard deviations over the 12 entries of the measured state, SI units."""
        attitude = math.radians(self.attitude_noise_deg)
        groups = (self.position_noise, attitude, self.velocity_noise, self.angular_velocity_noise)
        return [deviation for deviation in groups for _ in range(3)]


@dataclass
class Knowledge:
    """How far the truth is from what the UAV believes; by default it knows everything.

    The other sections say what the UAV believes. The truth is the belief plus the errors given here.
    """

    # True height of the ship's antenna above mean sea level minus `link.ship_antenna_height`, m.
    ship_antenna_height_error: float = _number(0.0, at_least=-1e4, at_most=1e4)
    # True minus measured position, m, world frame, and true minus measured Euler angles, deg.
    position_bias: list[float] = _vector(0.0, 0.0, 0.0, at_least=-1e3, at_most=1e3)
    attitude_bias_deg: list[float] = _vector(0.0, 0.0, 0.0, at_least=-90.0, at_most=90.0)
    # True transmit power minus `link.transmit_power_dbm`, dB.
    transmit_power_error_db: float = _number(0.0, at_least=-300.0, at_most=300.0)
    # How old the ship's track is when it is reported to the UAV, s.
    ship_latency: float = _number(0.0, at_least=0.0, at_most=86400.0)

    @property
    def pose_bias(self) -> list[float]:
        """True minus measured position, m, and Euler angles, rad."""
        return [*self.position_bias, *map(math.radians, self.attitude_bias_deg)]
