"""Robustness: the mission under each disturbance that the controller is not told of, as one table."""

from collections.abc import Mapping

from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import compute_metrics, gain_percent
from a2s_drake.guidance.laws import LAW_LABELS
from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.scenario import Scenario

_SINGLE: dict[str, list[str]] = {
    "gusts of 3 N across (1.5 s of every 5 s)": ["gust_force=[0, 3, 0]"],
    "gusts of 3 N towards the ship": ["gust_force=[3, 0, 0]"],
    "mass 10 % up": ["mass_factor=1.1"],
    "mass 10 % down": ["mass_factor=0.9"],
    "inertia 10 % up": ["inertia_factor=1.1"],
    "inertia 10 % down": ["inertia_factor=0.9"],
    "first rotor at 90 % thrust": ["rotor_efficiency=[0.9, 1, 1, 1, 1, 1]"],
    "noise of 1 cm, 0.5 deg, 5 cm/s, 0.02 rad/s": [
        *("position_noise=0.01", "attitude_noise_deg=0.5"),
        *("velocity_noise=0.05", "angular_velocity_noise=0.02"),
    ],
    "commands one period late": ["input_delay_periods=1"],
}

# What stands together in the last row: one of each kind.
_TOGETHER = [name for name in _SINGLE if "towards" not in name and "down" not in name]

DISTURBANCES: dict[str, list[str]] = {
    "none": [],
    **_SINGLE,
    "all of these (gusts across, mass and inertia up)": [setting for name in _TOGETHER for setting in _SINGLE[name]],
}


def _key(disturbance: str, law: str) -> str:
    return f"{disturbance}, {law}"


def robustness_scenarios(base: Scenario) -> dict[str, Scenario]:
    """A base scenario under each of `DISTURBANCES`, with its own law and level.

    Raises:
      ScenarioError: when one cannot be flown, or the scenario's law is level, which leaves nothing to compare.
    """
    if base.attitude_law.name == "level":
        raise refuse("attitude_law.name", "level", "must be another law, which is then compared with level")
    return {
        _key(disturbance, law): base.with_overrides(
            [f"attitude_law.name={law}", *(f"disturbance.{setting}" for setting in settings)]
        ).validate()
        for disturbance, settings in DISTURBANCES.items()
        for law in (base.attitude_law.name, "level")
    }


def robustness_table(flights: Mapping[str, Flight], law: str) -> str:
    """Tracking and throughput of a law under each disturbance, as Markdown, from flights of `robustness_scenarios`."""
    lines = [
        f"| disturbance | {LAW_LABELS[law]} | over level, same disturbance | position error max, rms | attitude error "
        "rms: roll, pitch, yaw | solver failures |",
        "|---|---|---|---|---|---|",
    ]
    for disturbance in DISTURBANCES:
        flight, level = (flights[_key(disturbance, name)] for name in (law, "level"))
        metrics, gain = compute_metrics(flight), gain_percent(flight, level)
        farthest, usual = 100 * metrics["position_error_max_m"], 100 * metrics["position_error_rms_m"]
        turned = ", ".join(f"{angle:.2f}" for angle in metrics["attitude_error_rms_deg"])
        failures = metrics["solver"]["failures"] + compute_metrics(level)["solver"]["failures"]
        lines.append(
            f"| {disturbance} | {metrics['throughput_bit_per_hz']:.1f} bit/Hz | {gain:+.1f} % | "
            f"{farthest:.1f}, {usual:.1f} cm | {turned} deg | {failures} |"
        )
    return "\n".join(lines)
