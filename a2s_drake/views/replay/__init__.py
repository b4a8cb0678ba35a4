"""Replay: a flight as a moving three-dimensional picture, live in a browser or recorded in one HTML file."""

from a2s_drake.views.replay.recording import write_replay
from a2s_drake.views.replay.scene import Scene
from a2s_drake.views.replay.stage import start_meshcat

__all__ = ["Scene", "start_meshcat", "write_replay"]
