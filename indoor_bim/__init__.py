"""From a laser scan of a building to its model."""

__version__ = "0.1.0"
