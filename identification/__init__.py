"""Identification: recordings in, noise models out.

`identify` is the door; the modules behind it are one step each: `preprocessing`, `arma_fit` and `windows` for
SG13's recipe, `structural` and `intervals` for maximum likelihood on the raw samples, `whiteness`,
`homogeneity`, `orders`, `averaging`, `surrogates` and `allan` for second opinions, `verdict` for what to
believe; `warming` for what temperature does.
"""

from baroarma.identification.arma_fit import fit_arma
from baroarma.identification.identification import Identification, identify
from baroarma.identification.population import compare_models, pool
from baroarma.identification.preprocessing import WindowSettings
from baroarma.identification.warming import warm_up

__all__ = ["Identification", "WindowSettings", "compare_models", "fit_arma", "identify", "pool", "warm_up"]
