"""Identification: recordings in, noise models out."""
