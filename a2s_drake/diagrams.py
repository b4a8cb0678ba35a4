"""The drawings of a clone, under the name that they have in the wheel: the same objects as in `diagrams`."""

from diagrams import *  # noqa: F403
