"""Exports: models and filters in the forms that other programs read.

Whole estimators as C source are in `baroarma.export.firmware`, which needs the estimators.
"""

from baroarma.export.coefficients import FORMATS, render
from baroarma.export.fixed_point import FixedPointFilter, quantise
from baroarma.export.hints import Hint, hints

__all__ = ["FORMATS", "FixedPointFilter", "Hint", "hints", "quantise", "render"]
