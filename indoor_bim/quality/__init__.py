"""Measuring models: against scans, other models and rules."""
