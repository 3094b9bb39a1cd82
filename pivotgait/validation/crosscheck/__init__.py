"""Cross-simulator tests for any URDF: do Pinocchio, PyBullet and MuJoCo see the same robot?

Made to be imported by other projects' tests::

    from pivotgait.validation.crosscheck import cross_check

    def test_every_simulator_sees_my_robot():
        found = cross_check("my_robot.urdf")
        assert found.agrees, found.table()

or, as a fixture of the pytest plugin ``pivotgait.pytest_plugin``, which fails with the table::

    def test_every_simulator_sees_my_robot(cross_simulators):
        cross_simulators("my_robot.urdf")
"""

from pivotgait.validation.crosscheck.checks import cross_check
from pivotgait.validation.crosscheck.found import CrossCheck, Row, Tolerances
from pivotgait.validation.crosscheck.reading import ENGINES, Reading

__all__ = ["ENGINES", "CrossCheck", "Reading", "Row", "Tolerances", "cross_check"]
