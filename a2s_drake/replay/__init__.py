"""Replay: a flight as a moving three-dimensional picture, live in a browser or recorded in one HTML file."""

from a2s_drake.replay.recording import write_replay
from a2s_drake.replay.scene import Scene
from a2s_drake.replay.stage import start_meshcat

__all__ = ["Scene", "start_meshcat", "write_replay"]
