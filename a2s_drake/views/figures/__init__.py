"""Figures of Flights and studies: plain matplotlib Figures at column width, no pyplot state; save with `savefig`."""

from a2s_drake.views.figures.attitude import attitude_error_figure, attitude_figure, reference_figure
from a2s_drake.views.figures.ceiling import affine_error_figure, attribution_figure, ceiling_figure
from a2s_drake.views.figures.geometry import geometry_figure
from a2s_drake.views.figures.limits import angular_velocity_figure, rotor_speed_figure, velocity_figure
from a2s_drake.views.figures.link import channel_gain_figure, outage_figure
from a2s_drake.views.figures.path import position_figure, trajectory_figure
from a2s_drake.views.figures.sensitivity import readings_figure
from a2s_drake.views.figures.style import save_figure

__all__ = [
    "affine_error_figure",
    "angular_velocity_figure",
    "attitude_error_figure",
    "attitude_figure",
    "attribution_figure",
    "ceiling_figure",
    "channel_gain_figure",
    "geometry_figure",
    "outage_figure",
    "position_figure",
    "readings_figure",
    "reference_figure",
    "rotor_speed_figure",
    "save_figure",
    "trajectory_figure",
    "velocity_figure",
]
