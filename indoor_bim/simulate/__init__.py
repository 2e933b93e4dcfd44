"""A virtual LiDAR walk through a known building."""
