"""How a sweep's numbers were made, in words that a paper's method section can use."""

from __future__ import annotations

from pivotgait.sweeps.axes import Axis
from pivotgait.sweeps.study_config import Compute
from pivotgait.sweeps.study_results import StudyResults

_COMPUTED: dict[Compute, str] = {
    "static": (
        "Each cell asks whether contact forces exist that hold the tool at rest after its lift, "
        "tip on the table: equilibrium of forces and moments, exact Coulomb cones at every "
        "contact, bounds of every normal force. The room to every limit is the largest force by "
        "which all of them could be tightened at once (negative: must be loosened), found by an "
        "interior-point method on second-order cones; the binding limit is the one with the "
        "largest multiplier."
    ),
    "removal": (
        "Each cell plans the gait up to its first removal of a finger, for the tool and its "
        "contact forces without the arm-hand: a trajectory of orientation and forces over K steps "
        "that keeps the Newton-Euler equations, exact friction cones and force bounds, and takes "
        "the leaving finger's force to zero on a ramp, with the least turn and acceleration and "
        "the best aligned forces."
    ),
    "plan": (
        "Each cell plans the whole gait with the arm-hand (forces, removals, postures, "
        "relocations) and certifies it by code that shares nothing with the planners."
    ),
    "trials": (
        "Each cell plans and certifies the whole gait with the arm-hand and carries it out in a "
        "physics simulator; a trial passes if every phase and a final hold are completed without "
        "slip, loss of a contact, collision, or a joint beyond its limits."
    ),
}


def methods(results: StudyResults) -> tuple[str, ...]:
    """Paragraphs on what was computed, varied and counted."""
    config = results.config
    varied = "; ".join(_axis(axis) for axis in results.cells.axes)
    fixed = ", ".join(f"{name} = {value:g}" for name, value in config.set.items())
    scene = f"The scene is {config.scene}, its gait {config.gait or 'the first one'}"
    paragraphs = [_COMPUTED[config.compute]]
    paragraphs.append(f"{scene}. Varied: {varied}.{f' Set: {fixed}.' if fixed else ''}")
    if results.drawn_axes:
        paragraphs.append(
            f"Distributions are drawn {results.cells.draws} times (seed {config.seed}); every "
            "place of the grid meets the same draws."
        )
    if config.trials is not None:
        given = config.trials
        kind = "perturbed" if given.perturbed else "nominal"
        paragraphs.append(
            f"{given.count} {kind} trials a cell in {given.simulator} with {given.controller} "
            f"control, from seed {config.seed}."
        )
    paragraphs.append(
        f"A cell is given up after {config.limit_s:g} s. {results.rows} of "
        f"{results.cells.count} cells are done; together they took {results.seconds:.3g} s of "
        "computing time."
    )
    return tuple(paragraphs)


def _axis(axis: Axis) -> str:
    config = axis.config
    if config.normal is not None:
        return f"{axis.parameter} normal, {config.normal.mean:g} ± {config.normal.sd:g}"
    bounds = config.uniform or config.loguniform
    if bounds is not None:
        return f"{axis.parameter} {axis.kind}, {bounds.from_:g} to {bounds.to:g}"
    first, last = axis.value(0), axis.value(axis.count - 1)
    if axis.named or axis.count < 4:
        return f"{axis.parameter} {', '.join(str(axis.value(k)) for k in range(axis.count))}"
    return f"{axis.parameter} {first} to {last} ({axis.count} values)"
