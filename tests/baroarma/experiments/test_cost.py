"""Operations counted by the machine are those counted by hand."""

from baroarma.experiments.cost import complementary_cost, kalman_cost


def test_the_complementary_filter_takes_22_operations():
    # z - h: 1; F x and B y: 6 each; y = K e: 2; dt a: 1; b times it: 2; two sums of vectors: 4
    assert complementary_cost() == 1 + 6 + 6 + 2 + 1 + 2 + 4


def test_the_kalman_filter_takes_84_operations():
    predict_x, predict_p = 6 + 2 + 2, 12 + 12 + 4
    gain = 6 + (6 + 3) + 1 + 2  # P h; h P h; + r; division of two
    update_x, update_p = 3 + 1 + 2 + 2, 4 + 4 + 12
    assert kalman_cost() == predict_x + predict_p + gain + update_x + update_p
