"""Plan geometry in two dimensions: rasters, lines, walls, corners, rooms."""
