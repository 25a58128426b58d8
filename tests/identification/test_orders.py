"""Which order an ARMA has."""

import numpy as np
import pytest

from baroarma.arma import ArmaModel
from baroarma.identification.orders import order_table

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)


def test_the_order_table_prefers_the_true_order_and_its_criteria_agree():
    table = order_table(SG13.simulate(2000, 5), 0.1, 2, 2)
    assert table.best("bic") == (1, 1)
    # FPE is AIC in another dress: n log FPE - AIC is the same for all orders but for terms d^3/n^2 and the
    # start-up of the likelihood (log-determinant over n, below 3 for these orders).
    difference = [2000 * np.log(fit.fpe) - fit.aic for order, fit in table.fits.items() if order != (0, 0)]
    assert np.ptp(difference) < 3
    assert table.summary().count("*") == 3
    with pytest.raises(ValueError, match="choose 'fpe', 'aic' or 'bic'"):
        table.best("r2")
