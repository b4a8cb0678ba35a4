"""The gauge: a panel that reads the SNR by the height of a bar, and draws it over time, beside a scale in dB."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.courses import Courses
from a2s_drake.link.two_ray import path_lengths, unit_gain
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.views.replay.shapes import Mesh, prism, strokes, text
from a2s_drake.views.replay.stage import Color, Stage, translation

TICK_DB = 5.0
DEEPEST_FADE_DB = 40.0  # below the best SNR; without it, a reflection as strong as the direct ray has no lowest SNR

# Where things stand on the panel, m, from its lower left corner; lengths are those of a vehicle of Table I's size.
WIDTH, HEIGHT = 1.36, 0.56
BOTTOM, TOP, HEADING = 0.11, 0.42, 0.49
BAR = (0.19, 0.27)
CHART = (0.34, 1.30)
LETTER, STROKE = 0.048, 0.0075

BACK: Color = (0.97, 0.97, 0.95)
INK: Color = (0.10, 0.12, 0.16)
FAINT: Color = (0.62, 0.65, 0.68)
FILL: Color = (0.0, 0.62, 0.45)
TRACE: Color = (0.0, 0.45, 0.70)


@dataclass(frozen=True)
class GaugeScale:
    """The gauge's scale: the SNRs at its lower and upper end, dB, whole multiples of TICK_DB."""

    low_db: float
    high_db: float

    def fraction(self, snr_db: float) -> float:
        """How far up the scale an SNR (dB) stands, 0..1. An SNR outside the scale stands at its end, no number at 0."""
        share = (snr_db - self.low_db) / (self.high_db - self.low_db)
        return float(np.clip(np.nan_to_num(share, nan=0.0), 0.0, 1.0))

    def ticks_db(self) -> FloatArray:
        """The ticks from bottom to top, dB."""
        return np.arange(self.low_db, self.high_db + TICK_DB / 2.0, TICK_DB)


def gauge_scale(scenario: Scenario, courses: Courses | None = None) -> GaugeScale:
    """The scale that holds every SNR on the reference paths, whatever the attitude and the phase between the rays.

    The antenna is at most |r_a| away from the centre of mass. So its distance from the ship's antenna and its height
    over the sea differ from those of the centre by at most |r_a|. The scale holds every such distance and height, from
    both rays in antiphase to both in phase. The two-ray formula ends where the antennas are one wavelength apart, and
    so does the scale. Its lower end is at most about 40 dB below its upper end.
    """
    link = scenario.true_link()
    courses = courses or Courses.of(scenario)
    position, ship = courses.positions(np.linspace(0.0, courses.end, 1000))
    # Between two of these instants nothing gets farther off than one step.
    step = np.max(np.linalg.norm(np.diff(ship - position, axis=0), axis=1))
    reach = float(np.linalg.norm(link.antenna_offset) + step)
    distance = path_lengths(position, ship, link)[0]
    near, far = np.maximum(distance - reach, link.wavelength), distance + reach
    # From d_ref^2 = d_los^2 + 4 h z follows: the sum and the difference of the rays both fall as d_los grows. As the
    # height z grows, the sum falls and the difference grows. So both are at their extremes where the antenna is lowest.
    lowest_height = np.maximum(position[:, 2] - ship[:, 2] - reach, 0.0)
    gamma, lift = link.reflection_magnitude, 4.0 * link.ship_antenna_height * lowest_height
    unit = link.transmit_to_noise * unit_gain(link)
    highest = 10.0 * np.log10(unit * np.max(1.0 / near + gamma / np.sqrt(near**2 + lift)) ** 2)
    lowest = 10.0 * np.log10(max(unit * np.min(1.0 / far - gamma / np.sqrt(far**2 + lift)) ** 2, 1e-300))
    low = TICK_DB * np.floor(max(lowest, highest - DEEPEST_FADE_DB) / TICK_DB)
    return GaugeScale(float(low), float(TICK_DB * np.ceil(highest / TICK_DB)))


def time_ticks(end: float) -> FloatArray:
    """Three to six round times from 0 to at most `end`, s."""
    step = 10.0 ** np.floor(np.log10(end))
    step *= next(factor for factor in (0.2, 0.5, 1.0, 2.0) if end / (factor * step) <= 5.0)
    return step * np.arange(int(np.floor(end / step * (1.0 + 1e-9))) + 1)


def _rectangle(left: float, right: float, bottom: float, top: float, depth: float) -> Mesh:
    """A slab whose face lies in the plane z = 0."""
    return prism(np.array([[left, bottom], [right, bottom], [right, top], [left, top]]), -depth, 0.0)


class Gauge:
    """The panel, in its frame G: x to the right, y up, z to whoever reads it.

    Args:
      stage: where it stands.
      path: its name there.
      X_PG: its pose in the parent; `size` scales it.
      scenario: whose flight it reads.
      courses: of that flight; those of the scenario without it.
    """

    def __init__(
        self,
        stage: Stage,
        path: str,
        X_PG: RigidTransform,
        size: float,
        scenario: Scenario,
        courses: Courses | None = None,
    ) -> None:
        self.scale = gauge_scale(scenario, courses)
        self._stage, self._path = stage, f"{path}/size"
        self._end = max(float(scenario.sample_times()[-1]), scenario.mpc.period)
        self._last: FloatArray | None = None
        self._traced = 0
        stage.place(path, X_PG)
        stage.meshcat.SetProperty(self._path, "scale", [size] * 3)
        self._draw()

    def _draw(self) -> None:
        stage, path = self._stage, self._path
        stage.put(f"{path}/back", _rectangle(0.0, WIDTH, 0.0, HEIGHT, 0.02), BACK, glow=0.6)
        frame, faint, words = [], [], [text("SNR dB", LETTER, (0.06, HEADING))]
        ticks = self.scale.ticks_db()
        labelled = ticks[:: 1 if len(ticks) <= 6 else 2]
        for level in ticks:
            y = self._height(level)
            if level in labelled:
                words.append(text(f"{level:.0f}", LETTER, (BAR[0] - 0.04, y - LETTER / 2.0), align=1.0))
            frame.append([[BAR[0] - 0.025, y], [BAR[0], y]])
            faint.append([[CHART[0], y], [CHART[1], y]])
        for time in time_ticks(self._end):
            x = self._across(time)
            words.append(text(f"{time:g}", LETTER, (x, BOTTOM - 0.075), align=0.5))
            faint.append([[x, BOTTOM], [x, TOP]])
        words.append(text("time s", LETTER, (CHART[1], HEADING), align=1.0))
        for left, right in (BAR, CHART):
            corners = np.array([[left, BOTTOM], [right, BOTTOM], [right, TOP], [left, TOP]])
            frame.extend(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
        layers = (("faint", np.array(faint), FAINT), ("frame", np.array(frame), INK), ("words", np.vstack(words), INK))
        for number, (name, segments, color) in enumerate(layers, start=1):
            stage.put(f"{path}/{name}", strokes(segments, STROKE if color is INK else STROKE / 2.0), color, glow=0.8)
            stage.place(f"{path}/{name}", translation([0.0, 0.0, 0.001 * number]))
        stage.place(f"{path}/curve", translation([0.0, 0.0, 0.004]))
        # The bar has height 1 and is scaled to the SNR.
        stage.put(f"{path}/bar/height", _rectangle(*BAR, 0.0, 1.0, 0.001), FILL, glow=0.8)
        stage.place(f"{path}/bar", translation([0.0, BOTTOM, 0.0018]))
        needle = np.array([[BAR[1], 0.0], [CHART[0] - 0.015, -0.025], [CHART[0] - 0.015, 0.025]])
        stage.put(f"{path}/needle", prism(needle, 0.0, 0.001), INK, glow=0.8)

    def _height(self, snr_db: float) -> float:
        return BOTTOM + self.scale.fraction(snr_db) * (TOP - BOTTOM)

    def _across(self, time: float) -> float:
        return CHART[0] + min(time / self._end, 1.0) * (CHART[1] - CHART[0])

    def show(self, snr_db: float) -> None:
        """Sets bar and needle to an SNR, dB."""
        y = self._height(snr_db)
        # A bar of height zero has no normals, and cannot be lit.
        self._stage.scale(f"{self._path}/bar/height", [1.0, max(y - BOTTOM, 1e-4), 1.0])
        self._stage.move(f"{self._path}/needle", translation([0.0, y, 0.003]))

    def trace(self, time: float, snr_db: float) -> None:
        """Continues the curve to an SNR, dB, at a time, s."""
        point = np.array([self._across(time), self._height(snr_db)])
        if self._last is not None:
            path = f"{self._path}/curve/{self._traced:04d}"
            self._stage.put(path, strokes(np.array([[self._last, point]]), STROKE), TRACE)
            self._stage.reveal(path)
            self._traced += 1
        self._last = point
