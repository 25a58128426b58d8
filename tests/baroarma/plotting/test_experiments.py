"""The plot of an experiment: both numbers of each row, with their SDs, in a panel per quantity."""

import matplotlib as mpl
import pytest

from baroarma.experiments.result import Result, Row
from baroarma.plotting import plot_result

mpl.use("Agg")
import matplotlib.pyplot as plt

ROWS = (
    Row("all", "DC gain", 0.21, None, 0.24, None, 1, "differs"),
    Row("Method A", "height RMSE (m)", 0.40, 0.15, 0.37, 0.12, 10, "within 1 SD"),
    Row("_B $x$", "height RMSE (m)", None, None, 0.08, 0.02, 10, ""),
    Row("A against B", "Wilcoxon (p)", 0.002, None, 0.001, None, 10, "within 1 SD"),
)
RESULT = Result("sg14-table-2", "walks <script>", (), ROWS)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def test_published_and_reproduced_numbers_stand_beside_each_other_with_their_sds():
    height, gain = RESULT.plot().axes  # the longer one first; p-values stay in the table
    published, ours = height.containers
    assert (height.get_xlabel(), gain.get_xlabel()) == ("height RMSE (m)", "DC gain")
    assert published.lines[0].get_xdata().tolist() == [0.40]
    assert ours.lines[0].get_xdata().tolist() == [0.37, 0.08]
    bar = ours.lines[2][0].get_segments()[0]
    assert bar[:, 0].tolist() == pytest.approx([0.25, 0.49])
    assert published.lines[0].get_marker() != ours.lines[0].get_marker()


def test_one_legend_serves_all_panels_and_hides_no_data():
    figure = RESULT.plot()
    figure.canvas.draw()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["published", "ours"]
    box = legend.get_window_extent()
    assert not any(box.overlaps(ax.get_tightbbox()) for ax in figure.axes)
    assert not figure.texts[0].get_window_extent().overlaps(figure.axes[0].get_tightbbox())


def test_rows_keep_their_order_from_top_to_bottom_and_their_names():
    height = RESULT.plot().axes[0]
    assert height.yaxis_inverted()
    assert [text.get_text().strip() for text in height.get_yticklabels()] == ["Method A", r"_B \$x\$"]


def test_p_values_alone_are_refused_in_a_sentence():
    with pytest.raises(ValueError, match="sg14-table-2 has p-values only"):
        plot_result(Result("sg14-table-2", "walks", (), ROWS[3:]))
