"""Estimators: recordings and noise models in, states out."""
