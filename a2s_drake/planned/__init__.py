"""The law `planned`: an attitude over time, computed before take-off, that the vehicle is known to be able to fly."""
