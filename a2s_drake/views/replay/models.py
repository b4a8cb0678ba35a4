"""What the scene shows that keeps its shape: the hexarotor, the ship, and the sea."""

import numpy as np
from pydrake.geometry import Cylinder, Ellipsoid, Rgba, Sphere

from a2s_drake.common.arrays import FloatArray
from a2s_drake.scenario.parts import Airframe, Link
from a2s_drake.vehicle.airframe import rotor_table
from a2s_drake.views.replay.shapes import prism, tube
from a2s_drake.views.replay.stage import Color, Stage, translation

BODY: Color = (0.16, 0.18, 0.22)
NOSE: Color = (0.85, 0.10, 0.10)
ANTENNA: Color = (0.95, 0.75, 0.0)
# Rotors by the sense in which they turn, seen from above: +1 counter-clockwise, -1 clockwise.
SPIN: dict[int, Color] = {1: (0.0, 0.60, 0.85), -1: (0.90, 0.30, 0.05)}
HULL: Color = (0.45, 0.10, 0.10)
DECK: Color = (0.93, 0.93, 0.90)
FOAM: Color = (0.85, 0.93, 0.96)
SEA: Color = (0.10, 0.36, 0.52)
GRID: Color = (0.22, 0.48, 0.62)

SHADE = 0.6  # what of their colour the ship and the sea show in the shade: most light falls on the vehicle
MOST_SQUARES = 40  # of the sea's grid, from its middle to an edge
ROTOR_RADIUS = 0.45  # of the distance between neighbouring hubs, so that no two discs meet


def blades_path(vehicle: str, rotor: int) -> str:
    """The path of a rotor's blades, which turn about the z axis of the rotor's frame P."""
    return f"{vehicle}/rotor_{rotor}/blades_slowed_down"


def put_vehicle(stage: Stage, path: str, airframe: Airframe, link: Link) -> None:
    """The hexarotor in its body frame B, at its true size, with each rotor in its frame P of `rotor_table`."""
    rotors = rotor_table(airframe)
    arm = airframe.arm_length
    radius = ROTOR_RADIUS * arm
    stage.put(f"{path}/hub", Ellipsoid(0.28 * arm, 0.28 * arm, 0.13 * arm), BODY)
    nose = tube(np.array([0.2 * arm, 0.0, 0.03 * arm]), np.array([0.5 * arm, 0.0, 0.03 * arm]), 0.07 * arm, 1e-4)
    stage.put(f"{path}/nose", nose, NOSE)
    for i, rotor in enumerate(rotors):
        hub = rotor.X_BP.translation()
        color = SPIN[spin_sense(rotor.moment_ratio)]
        stage.put(f"{path}/arm_{i}", tube(np.zeros(3), hub, 0.045 * arm, 0.035 * arm), BODY)
        place = f"{path}/rotor_{i}"
        stage.place(place, rotor.X_BP)
        stage.put(f"{place}/motor/shape", Cylinder(0.075 * arm, 0.16 * arm), BODY)
        stage.put(f"{place}/disc/shape", Cylinder(radius, 0.004 * arm), color, opacity=0.35)
        stage.place(f"{place}/disc", translation([0.0, 0.0, 0.11 * arm]))
        blade = np.array([[-1.0, -0.06], [1.0, -0.06], [1.0, 0.06], [-1.0, 0.06]])
        stage.put(blades_path(path, i), prism(radius * blade, 0.115 * arm, 0.135 * arm), color)
    offset = np.asarray(link.antenna_offset)
    stage.put(f"{path}/antenna_boom", tube(np.zeros(3), offset, 0.025 * arm, 0.02 * arm), BODY)
    stage.put(f"{path}/antenna/shape", Sphere(0.08 * arm), ANTENNA)
    stage.place(f"{path}/antenna", translation(offset))


def spin_sense(moment_ratio: float) -> int:
    """The sense in which a rotor turns about its z axis: against the torque that its drag puts on the body."""
    return -1 if moment_ratio > 0.0 else 1


def put_ship(stage: Stage, path: str, height: float, *, under_way: bool) -> None:
    """A ship with its bow on +x, sized by the antenna's height (m) over its origin: a scenario says no more of it."""
    h = height
    stern, bow, beam, board, house = -1.5 * h, 2.1 * h, 0.48 * h, 0.22 * h, 0.5 * h
    outline = [[stern, -0.85 * beam], [0.9 * h, -beam], [1.5 * h, -0.7 * beam]]
    outline += [[bow, 0.0], [1.5 * h, 0.7 * beam], [0.9 * h, beam], [stern, 0.85 * beam]]
    hull = np.array(outline)
    stage.put(f"{path}/hull", prism(hull, -0.1 * h, board), HULL, glow=SHADE)
    stage.put(f"{path}/deck", prism(0.97 * hull, board, board + 0.02 * h), DECK, glow=SHADE)
    for name, aft, fore, side, bottom, roof, color in (
        ("house", -0.9 * h, 0.5 * h, 0.75 * beam, board, 0.36 * h, DECK),
        ("bridge", -0.3 * h, 0.4 * h, 0.9 * beam, 0.36 * h, house, DECK),
        ("windows", -0.31 * h, 0.41 * h, 0.91 * beam, 0.42 * h, 0.465 * h, BODY),
    ):
        walls = np.array([[aft, -side], [fore, -side], [fore, side], [aft, side]])
        stage.put(f"{path}/{name}", prism(walls, bottom, roof), color, glow=SHADE)
    funnel = np.array([[-0.65 * h, 0.0, 0.3 * h], [-0.65 * h, 0.0, 0.56 * h]])
    stage.put(f"{path}/funnel", tube(funnel[0], funnel[1], 0.1 * h, 0.08 * h), HULL, glow=SHADE)
    top = np.array([0.0, 0.0, h])
    stage.put(f"{path}/mast", tube(np.array([0.0, 0.0, house]), top, 0.03 * h, 0.015 * h), BODY)
    yard = np.array([0.0, 0.3 * beam, 0.0])
    stage.put(f"{path}/yard", tube(0.85 * top - yard, 0.85 * top + yard, 0.012 * h, 0.012 * h), BODY)
    stage.put(f"{path}/antenna/shape", Sphere(0.035 * h), ANTENNA)
    stage.place(f"{path}/antenna", translation(top))
    if under_way:
        for name, side in (("port", 1.0), ("starboard", -1.0)):
            wake = np.array([[stern, 0.5 * beam], [stern, 0.85 * beam], [stern - 4.0 * h, 2.0 * beam]])
            wake = wake[:: int(side)] * [1.0, side]
            stage.put(f"{path}/wake_{name}", prism(wake, 0.0, 0.012 * h), FOAM, glow=SHADE)


def put_sea(stage: Stage, path: str, center: FloatArray, reach: float) -> None:
    """The sea's surface, as far as the eye can see, and on it a grid as far as `reach` (m).

    Its squares are 10 m wide, or 100 m, 1 km and so on where it would take more than MOST_SQUARES from the middle out.

    Args:
      center: the grid's middle, m, W, shape (3,), at sea level.
    """
    far = 20.0 * reach
    corners = far * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    stage.put(f"{path}/surface", prism(corners, -0.01 * reach, 0.0), SEA, glow=SHADE)
    square = 10.0
    while reach / square > MOST_SQUARES:
        square *= 10.0
    squares = np.ceil(reach / square)
    ticks = square * np.arange(-squares, squares + 1.0)
    # The grid is drawn square by square, because some browsers drop a line that has an end behind the eye. It is drawn
    # above the surface, so that the two do not flicker through each other.
    across, along = (grid.ravel() for grid in np.meshgrid(ticks, ticks[:-1]))
    above = np.full_like(across, 0.2)
    start = np.hstack([[across, along, above], [along, across, above]])
    end = np.hstack([[across, along + square, above], [along + square, across, above]])
    stage.meshcat.SetLineSegments(f"{path}/grid_of_{square:.0f}_m", start, end, 1.0, Rgba(*GRID))
    stage.place(path, translation(center))
