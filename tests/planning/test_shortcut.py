"""Shortcuts keep the ends, the chain and the collision rule, and never lengthen."""

import numpy as np

from pivotgait.benchmarks.relocation import Task
from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.rrt import search
from pivotgait.planning.shortcut import path_length, shorten
from pivotgait.planning.steering import steer


def test_shortcuts(problems: dict[str, RelocationProblem]) -> None:
    problem = problems["middle, straight way blocked"]
    task, stride = Task(problem), problem.options.stride
    manifold, validity = task.manifold, task.validity
    found = search(problem, manifold, validity, task.ends, np.random.default_rng(1))
    assert found.outcome == "found"
    before = path_length(manifold, found.q, found.s)
    rng = np.random.default_rng(2)
    q, s = shorten(manifold, validity, found.q, found.s, 40, stride, rng)
    np.testing.assert_array_equal(q[[0, -1]], found.q[[0, -1]])
    assert path_length(manifold, q, s) < before
    for k in range(len(s) - 1):
        assert manifold.motion(q[k], s[k], q[k + 1], s[k + 1]) <= 2.2 * stride
        assert validity.way_free(q[k], s[k], q[k + 1], s[k + 1])
        assert manifold.hold_error(q[k], s[k]) < 2e-5


def test_a_straight_way_cannot_be_shortened(first_contact: RelocationProblem) -> None:
    task = Task(first_contact)
    stride = first_contact.options.stride
    states = list(steer(task.manifold, task.validity, *task.ends, stride))
    assert states[-1][0] is task.ends[1][0]
    q = np.array([task.ends[0][0], *(state[0] for state in states)])
    s = np.array([0.0, *(state[1] for state in states)])
    rng = np.random.default_rng(0)
    again, _ = shorten(task.manifold, task.validity, q, s, 20, stride, rng)
    assert path_length(task.manifold, again, s[: len(again)]) <= path_length(task.manifold, q, s)
    direct = task.manifold.motion(q[0], 0.0, q[-1], 1.0)
    assert direct <= path_length(task.manifold, q, s) < 1.3 * direct
