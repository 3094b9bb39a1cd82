import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pivotgait.plotting.labels import spread

heights = st.lists(st.floats(0.0, 1.0), max_size=8).map(sorted)


@given(heights)
def test_labels_never_touch_and_keep_their_order(wanted):
    placed = spread(wanted, 0.1)
    assert np.all(np.diff(placed) >= 0.1 - 1e-9)
    assert len(placed) == len(wanted)


@given(heights)
def test_labels_that_crowd_stay_on_the_panel(wanted):
    placed = spread(wanted, 0.1)
    assert np.all((placed >= -1e-9) & (placed <= 1.0 + 1e-9))


def test_labels_with_room_stay_where_they_are():
    np.testing.assert_array_equal(spread([0.1, 0.5, 0.9], 0.1), [0.1, 0.5, 0.9])
