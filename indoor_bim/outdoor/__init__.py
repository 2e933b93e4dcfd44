"""Houses from an outdoor scan: ground, walls, footprints, heights, and the model that holds them."""
