"""The pictures: every figure of the report, by file name, with its caption."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from a2s_drake.flight.log import Flight
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ideal_tracking import Geometry, phase_errors
from a2s_drake.study.paper.results import PlannedLaw, Results
from a2s_drake.views import figures

# File name: figure, caption.
Pictures = dict[str, tuple[Figure, str]]


def paper_pictures(flights: Mapping[str, Flight]) -> Pictures:
    """The paper's figures, redrawn from the headline flights by law."""
    flight = flights["three_axis"]
    return {
        "geometry": (
            figures.geometry_figure(),
            "The two rays in the vertical plane of the link. Turning the UAV moves the antenna from the hollow dot to "
            "the full one, which changes both path lengths. Not to scale.",
        ),
        "trajectory": (
            figures.trajectory_figure(flight),
            "Flown trajectories of UAV and ship, and the UAV's circle from above; the ship lies to the right.",
        ),
        "position": (
            figures.position_figure(flights),
            "Position against time under the three-axis law, and the distance from the path under each law. The steady "
            "offset in z is the price of the weight on the input.",
        ),
        "channel_gain": (figures.channel_gain_figure(flights), "Channel gain under the three laws."),
        "outage": (
            figures.outage_figure(flights),
            "Share of the mission with an SNR below a threshold; dots at 0, 3, 6, 9 and 12 dB.",
        ),
        "reference": (figures.reference_figure(flight), "Communication-optimal Euler angles: what the law asks for."),
        "attitude_error": (
            figures.attitude_error_figure(flight),
            "Tracking error: flown minus asked-for angles.",
        ),
        "attitude": (figures.attitude_figure(flight), "Flown against asked-for attitude, axis by axis."),
        "velocity": (figures.velocity_figure(flight), "Velocity of the centre of mass and its bounds."),
        "angular_velocity": (
            figures.angular_velocity_figure(flight),
            "Angular velocity in the body frame, its bounds.",
        ),
        "rotor_speed": (figures.rotor_speed_figure(flight), "The six rotor speeds and their bounds."),
    }


def planned_pictures(planned_law: PlannedLaw, flights: Mapping[str, Flight]) -> Pictures:
    """The law `planned` beside the paper's, from the report's numbers and the flights of Table I as printed, by law."""
    planned, compared = flights["planned"], {law: flights[law] for law in ("three_axis", "planned", "level")}
    return {
        "planned_channel_gain": (
            figures.channel_gain_figure(compared),
            "Channel gain under the paper's law, the plan, and level; Table I as printed.",
        ),
        "planned_outage": (
            figures.outage_figure(compared),
            "Share of the mission with an SNR below a threshold; dots at 0, 3, 6, 9 and 12 dB.",
        ),
        "planned_attitude": (figures.attitude_figure(planned), "The plan, and what is flown of it: they coincide."),
        "planned_angular_velocity": (
            figures.angular_velocity_figure(planned),
            "Angular velocity under the plan, its bounds.",
        ),
        "planned_rotor_speed": (
            figures.rotor_speed_figure(planned),
            "The six rotor speeds under the plan and their bounds, which it uses to the full.",
        ),
        "attribution": (
            figures.attribution_figure(planned_law.attribution),
            "From the best attitude in the box down to what is flown: the gain over level that is left after each "
            "effect, and (hatched) what the effect costs.",
        ),
    }


def study_pictures(results: Results, printed: Scenario) -> Pictures:
    """The figures of what the paper leaves open, from the report's numbers and the scenario of Table I as printed."""
    pictures: Pictures = {}
    if results.readings is not None:
        pictures["readings"] = (
            figures.readings_figure(results.readings, results.paper_gain_percent),
            "How far each reading moves the headline, one at a time, from either base. All flown in closed loop.",
        )
    pictures["ceiling"] = (
        figures.ceiling_figure(results.ceilings),
        "Gain over level, and in brackets its share of the best in the box of the same scenario: ceilings (hatched), "
        "ideal tracking (dotted) and closed loop (solid).",
    )
    geometry = Geometry.of(printed)
    error = figures.affine_error_figure(geometry.time, phase_errors(printed, geometry))
    caption = "Error of the affine phase on the boundary of the attitude box. A fringe is 6.28 rad wide."
    return pictures | {"affine_phase_error": (error, caption)}
