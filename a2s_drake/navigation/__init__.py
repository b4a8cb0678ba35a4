"""What the UAV may know: sensors and the estimates made from them."""
