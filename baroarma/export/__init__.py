"""Exports: models and filters in the forms that other programs read."""

from baroarma.export.coefficients import FORMATS, render

__all__ = ["FORMATS", "render"]
