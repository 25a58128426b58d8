"""Simulated motions and sensors."""
