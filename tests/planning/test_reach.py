"""The bound on motion holds for every pair of shapes."""

import numpy as np
import pinocchio as pin

from pivotgait.benchmarks.relocation import Grip


def test_no_two_shapes_move_more_than_the_bound(grip: Grip) -> None:
    world, rng = grip.world, np.random.default_rng(0)
    model, geometry = world.bodies.model, world.bodies.geometry
    data, shapes = model.createData(), geometry.createData()
    robot, rest = world.robot, pin.neutral(model)[-7:]
    tightest = np.inf
    for _ in range(60):
        q = rng.uniform(robot.lower, robot.upper)
        change = rng.normal(size=robot.nv) * (rng.random(robot.nv) < 0.3) * 0.02
        distances = []
        for each in (q, q + change):
            full = np.concatenate((each, rest))
            pin.computeDistances(model, data, geometry, shapes, full)
            distances.append([result.min_distance for result in shapes.distanceResults])
        changed = np.abs(np.diff(distances, axis=0)).max()
        bound = float((world.bounds @ np.abs(change)).max())
        assert changed <= bound + 1e-5
        if bound > 0.0:
            tightest = min(tightest, bound / max(changed, 1e-9))
    assert tightest < 10.0
