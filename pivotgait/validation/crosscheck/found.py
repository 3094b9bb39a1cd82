"""What a cross-check found, as rows and as a table."""

from __future__ import annotations

from dataclasses import dataclass

from pivotgait.validation.tolerance_check import check_tolerances


@dataclass(frozen=True)
class Tolerances:
    """Deviations from the first engine up to which a row holds.

    Rounding leaves about 1e-10; what is wrong in a model is larger by orders of magnitude.

    Attributes:
        mass_matrix: largest deviation of an entry over the largest entry.
        inverse_dynamics: largest deviation of a torque over the largest torque.
        position_m: of a link's origin [m].
        orientation_rad: of a link's axes [rad].
        limit: of a joint's position limit [rad] or [m].
        effort: of an effort limit, over the limit.
        friction: of the friction coefficient at which a body slips, over the one asked for.
    """

    mass_matrix: float = 1e-6
    inverse_dynamics: float = 1e-6
    position_m: float = 1e-6
    orientation_rad: float = 1e-6
    limit: float = 1e-6
    effort: float = 1e-6
    friction: float = 0.05

    def __post_init__(self) -> None:
        check_tolerances(self)


@dataclass(frozen=True)
class Row:
    """One comparison of an engine with the first one.

    Attributes:
        engine: name.
        quantity: what was compared.
        deviation: largest; infinite where the engine has nothing to compare.
        tolerance: it must not exceed.
        where: joint, link or direction of the largest deviation, or why there is none.
    """

    engine: str
    quantity: str
    deviation: float
    tolerance: float
    where: str

    @property
    def holds(self) -> bool:
        """Whether the deviation is within its tolerance."""
        return self.deviation <= self.tolerance


@dataclass(frozen=True)
class CrossCheck:
    """All comparisons of one robot.

    Attributes:
        robot: name.
        reference: engine that the others are held against.
        rows: in the order of the engines.
    """

    robot: str
    reference: str
    rows: tuple[Row, ...]

    @property
    def agrees(self) -> bool:
        """Whether every row holds."""
        return all(row.holds for row in self.rows)

    def table(self) -> str:
        """Lines of text for people: every row, those that do not hold marked."""
        cells = [
            (
                "" if row.holds else "!!",
                row.engine,
                row.quantity,
                f"{row.deviation:.1e}",
                f"{row.tolerance:.0e}",
                row.where,
            )
            for row in self.rows
        ]
        head = ("", "engine", "quantity", "deviation", "allowed", "largest at")
        widths = [max(len(row[k]) for row in (head, *cells)) for k in range(len(head))]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in (head, *cells)
        ]
        failed = sum(not row.holds for row in self.rows)
        said = f"{failed} of {len(self.rows)} comparisons fail" if failed else "all agree"
        return "\n".join([f"{self.robot} against {self.reference}: {said}", *lines])
