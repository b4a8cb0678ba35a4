"""Scene: the flight in three dimensions on a Meshcat page, one instant at a time."""

import numpy as np
from pydrake.geometry import Meshcat, MeshcatAnimation, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.flight.log import Sample
from a2s_drake.guidance.courses import Courses
from a2s_drake.link.two_ray import antenna_position, ship_antenna_and_image, specular_point
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.airframe import NUM_ROTORS, rotor_table
from a2s_drake.views.replay.gauge import Gauge
from a2s_drake.views.replay.models import ROTOR_RADIUS, blades_path, put_sea, put_ship, put_vehicle, spin_sense
from a2s_drake.views.replay.shapes import prism, tube
from a2s_drake.views.replay.stage import Color, Stage, translation

WORLD = "world_seen_from_vehicle"
VEHICLE = f"{WORLD}/vehicle"
SHIP = f"{WORLD}/ship_sized_by_its_antenna"
RAYS = f"{WORLD}/rays_widened_with_distance"
GAUGE = "gauge"

DIRECT: Color = (1.0, 0.85, 0.10)
REFLECTED: Color = (1.0, 0.45, 0.75)
REFERENCE_PATH: Color = (0.80, 0.88, 0.92)
FLOWN: Color = (0.45, 0.95, 0.35)

SLOWDOWN = 100.0  # of the blades: at their true 60 Hz nobody would see them turn
PIECES = 250  # at most, of the path and of the gauge's curve over a whole flight

# The view, in the frame D of `view_frame`; lengths are those of a vehicle of Table I's size.
REACH = 0.585  # from the centre of mass to the antenna, m
EYE = np.array([-2.15, -1.95, 0.80])
LOOK_AT = np.array([0.35, -0.90, 0.55])
FIELD_OF_VIEW_DEG = 40.0
GAUGE_CORNER = np.array([-1.2, 0.32, -2.6])  # from the eye: to the right, up, back
PATH_RADIUS = 0.01  # m
RAY_WIDTH = 1.5e-3  # radius over distance from the eye


def view_frame(scenario: Scenario, courses: Courses | None = None) -> RotationMatrix:
    """R_WD of the frame that the view stands in: x to the middle of the ship's mast at mid-mission, y level, z up."""
    half = np.array(0.5 * scenario.mission.duration)
    mast = np.array([0.0, 0.0, 0.5 * scenario.true_link().ship_antenna_height])
    position, ship = (courses or Courses.of(scenario)).positions(half)
    ahead = ship + mast - position
    across = np.cross([0.0, 0.0, 1.0], ahead)
    if np.linalg.norm(across) < 1e-9 * max(1.0, float(np.linalg.norm(ahead))):
        across = np.array([0.0, 1.0, 0.0])  # the ship is right below
    x, y = ahead / np.linalg.norm(ahead), across / np.linalg.norm(across)
    return RotationMatrix(np.column_stack([x, y, np.cross(x, y)]))


def eye_frame(backward: FloatArray) -> RotationMatrix:
    """R_WE of the eye's frame: x to the right and level, y up, z backward along the vector given (3), W."""
    x = np.cross([0.0, 0.0, 1.0], backward)
    x, z = x / np.linalg.norm(x), backward / np.linalg.norm(backward)
    return RotationMatrix(np.column_stack([x, np.cross(z, x), z]))


def ray_pose(start: FloatArray, end: FloatArray) -> tuple[RigidTransform, float]:
    """Pose in W of a frame at a ray's start whose x axis runs along the ray, and the ray's length, m."""
    length = float(np.linalg.norm(end - start))
    direction = (end - start) / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
    return RigidTransform(RotationMatrix.MakeFromOneVector(direction, 0), start), length


class Scene:
    """Vehicle, ship, sea, both rays, the paths and the SNR gauge, almost all of it to scale.

    Everything stands at its true place in the world frame W and in its true size, with three exceptions. The names in
    the scene's tree tell of them. The rays are drawn wider with distance from the eye, so that they can be followed to
    the ship. The blades turn a hundred times slower than the rotors. The ship's hull is sized by the height of its
    antenna, because a scenario says nothing of the hull.

    The eye travels with the vehicle and does not turn. This is why W itself moves in the scene's tree. The gauge hangs
    beside the vehicle.

    Args:
      meshcat: the page; what is on it already stays.
      scenario: whose flight is shown.
      recording: where movements go instead of onto the page.
      last_frame: the recording's last frame; its frames are whole controller periods.
      courses: of the flight; those of the scenario without it.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        scenario: Scenario,
        recording: MeshcatAnimation | None = None,
        last_frame: int = 0,
        courses: Courses | None = None,
    ) -> None:
        self._scenario, self._courses = scenario, courses or Courses.of(scenario)
        self._stage = Stage(meshcat, recording, last_frame)
        self._spin = np.array([spin_sense(rotor.moment_ratio) for rotor in rotor_table(scenario.airframe)])
        self._angle = np.zeros(NUM_ROTORS)
        self._speed = np.zeros(NUM_ROTORS)
        self._time = 0.0
        self._duration = float(scenario.sample_times()[-1])
        self._drawn: tuple[float, FloatArray] | None = None
        self._pieces = 0
        self._ship_yaw = 0.0
        self._put_up()

    def _put_up(self) -> None:
        stage, scenario = self._stage, self._scenario
        mission, link, airframe = scenario.mission, scenario.true_link(), scenario.airframe
        R_WD = view_frame(scenario, self._courses)
        reach = max((1.0 + ROTOR_RADIUS) * airframe.arm_length, float(np.linalg.norm(link.antenna_offset)))
        size = reach / REACH
        self._dress_page(R_WD, size)
        path, ship = self._courses.positions(np.linspace(0.0, self._courses.end, 200))
        span = float(np.max(np.linalg.norm(ship - path, axis=1)))
        put_sea(stage, f"{WORLD}/sea", np.array([*(0.5 * (path[0] + ship[-1]))[:2], mission.sea_level]), 2.0 * span)
        put_vehicle(stage, VEHICLE, airframe, link)
        put_ship(stage, SHIP, link.ship_antenna_height, under_way=bool(np.any(ship != ship[0])))
        stage.meshcat.SetLine(f"{WORLD}/reference_path", path.T, 1.0, Rgba(*REFERENCE_PATH, 0.7))
        # Each ray is one long, then scaled to its length; its ends look equally wide from the eye.
        near, far = RAY_WIDTH * size * float(np.linalg.norm(EYE)), RAY_WIDTH * span
        height = path[0, 2] - mission.sea_level
        bounce = near + (far - near) * float(np.clip(height / (height + link.ship_antenna_height), 0.0, 1.0))
        x = np.array([1.0, 0.0, 0.0])
        for name, start, end, color in (
            ("direct", near, far, DIRECT),
            ("down_to_sea", near, bounce, REFLECTED),
            ("up_from_sea", bounce, far, REFLECTED),
        ):
            stage.put(f"{RAYS}/{name}/length", tube(np.zeros(3), x, start, end), color, glow=0.9)
        mark = 6.0 * bounce * np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0.0, 2.0 * np.pi, 24, False)])
        stage.put(f"{RAYS}/specular_point", prism(mark, 0.0, 0.4), REFLECTED, glow=0.9)
        p_WE = R_WD @ (size * EYE)
        R_WE = eye_frame(p_WE - R_WD @ (size * LOOK_AT))
        X_WG = RigidTransform(R_WE, p_WE + R_WE @ (size * GAUGE_CORNER))
        self._gauge = Gauge(stage, GAUGE, X_WG, size, scenario, self._courses)

    def _dress_page(self, R_WD: RotationMatrix, size: float) -> None:
        """Sky, lights and camera."""
        meshcat = self._stage.meshcat
        for name in ("/Grid", "/Axes"):
            meshcat.SetProperty(name, "visible", False)
        meshcat.SetProperty("/Background/<object>", "top_color", [0.45, 0.66, 0.88])
        meshcat.SetProperty("/Background/<object>", "bottom_color", [0.90, 0.95, 1.0])
        camera = Meshcat.PerspectiveCamera(fov=FIELD_OF_VIEW_DEG, near=0.2 * size, far=2e5)
        meshcat.SetCamera(camera)
        meshcat.SetCameraPose(R_WD @ (size * EYE), R_WD @ (size * LOOK_AT))

    def show(self, sample: Sample, frame: int | None = None) -> None:
        """Shows one instant; on a live page at once, in a recording at its frame. Instants come in order of time.

        Args:
          sample: see `Flight.sample`.
          frame: the frame of the recording.
        """
        stage, link = self._stage, self._scenario.true_link()
        stage.frame = frame or 0
        time, p_WB, eta = float(sample["time"]), sample["position"], sample["attitude"]
        ship, snr_db = sample["ship_position"], float(sample["snr_db"])
        stage.move(WORLD, translation(-p_WB))
        stage.move(VEHICLE, RigidTransform(RotationMatrix(rotation_matrix(eta)), p_WB))
        self._turn_blades(time, sample["rotor_speed"])
        stage.move(SHIP, RigidTransform(self._heading(time), ship))
        antenna, top = antenna_position(p_WB, eta, link), ship_antenna_and_image(ship, link)[0]
        bounce = specular_point(antenna, top, float(ship[2]))
        for name, start, end in (
            ("direct", antenna, top),
            ("down_to_sea", antenna, bounce),
            ("up_from_sea", bounce, top),
        ):
            X_WR, length = ray_pose(start, end)
            stage.move(f"{RAYS}/{name}", X_WR)
            stage.scale(f"{RAYS}/{name}/length", [length, 1.0, 1.0])
        stage.move(f"{RAYS}/specular_point", translation(bounce))
        self._gauge.show(snr_db)
        self._draw_on(time, p_WB, snr_db)

    def _turn_blades(self, time: float, rotor_speed: FloatArray) -> None:
        """Turns the blades on since the last instant. Without a rotor speed (ideal tracking) they stand still."""
        self._angle += self._spin * (2.0 * np.pi / SLOWDOWN) * self._speed * (time - self._time)
        self._time, self._speed = time, np.nan_to_num(rotor_speed, nan=0.0)
        for rotor, angle in enumerate(self._angle):
            X = RigidTransform(RotationMatrix.MakeZRotation(angle), np.zeros(3))
            self._stage.move(blades_path(VEHICLE, rotor), X)

    def _heading(self, time: float) -> RotationMatrix:
        """The ship points in the direction in which it sails; where it stands still, it points as before."""
        # The velocity at the end of the track is not zero, so a ship that has arrived points in that direction.
        x, y, _ = self._courses.ship.velocity(np.array(np.clip(time, 0.0, self._courses.ship.end)))
        if np.hypot(x, y) > 1e-6:  # m/s; the velocity of a spline is never exactly zero
            self._ship_yaw = float(np.arctan2(y, x))
        return RotationMatrix.MakeZRotation(self._ship_yaw)

    def _draw_on(self, time: float, p_WB: FloatArray, snr_db: float) -> None:
        """Draws the next piece of the path and of the gauge's curve, when it is time for it."""
        if self._drawn is None:
            self._drawn = (time, p_WB)
            self._gauge.trace(time, snr_db)
        last, start = self._drawn
        if time < self._duration and time - last < self._duration / PIECES:
            return
        self._drawn = (time, p_WB)
        self._gauge.trace(time, snr_db)
        if np.any(p_WB != start):
            path = f"{WORLD}/path_so_far/{self._pieces:04d}"
            self._stage.put(path, tube(start, p_WB, PATH_RADIUS, PATH_RADIUS, sides=5), FLOWN)
            self._stage.reveal(path)
            self._pieces += 1
