"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SceneArgument = Annotated[str, typer.Argument(help="A built-in scene's name or a YAML file.")]
PlanFile = Annotated[Path, typer.Argument(help="Plan file.")]
RobotPlanFile = Annotated[Path, typer.Argument(help="Plan file, with the motion of a robot.")]

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the random generator.")]
Gait = Annotated[str | None, typer.Option(help="Which of the scene's gaits; else the first.")]
Hand = Annotated[
    bool,
    typer.Option(
        "--hand/--no-hand", help="Plan the arm-hand too, or the tool's motion and forces alone."
    ),
]
Simulator = Annotated[str, typer.Option(help="pybullet or mujoco.")]
Controller = Annotated[str, typer.Option(help="hybrid, admittance, position or feedforward.")]
Trials = Annotated[int, typer.Option(min=1, max=100_000, help="Number of trials; one is nominal.")]
Workers = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Processes at a time; else all cores.")
]
