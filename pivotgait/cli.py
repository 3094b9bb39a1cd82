"""The command line: names, options and help of the commands."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer

from pivotgait.exceptions import PivotGaitError

app = typer.Typer(
    name="pivotgait",
    help="Dynamic finger gaits on a pivoting hand tool: plan, certify and explain.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)

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
SceneArgument = Annotated[str, typer.Argument(help="A built-in scene's name or a YAML file.")]


@app.command()
def plan(
    scene: SceneArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Plan file to write.")] = Path(
        "plan.h5"
    ),
    seed: Seed = 0,
    gait: Gait = None,
    hand: Hand = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Plan every phase of a gait, certify it and write the plan file.

    Example: `pivotgait plan knife -o knife.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.planning import run_plan

    return run_plan(scene, output, seed, gait, Output(json), hand=hand)


@app.command()
def certify(
    plan: Annotated[Path, typer.Argument(help="Plan file.")],
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Recompute a plan's certificate from the file alone.

    Example: `pivotgait certify knife.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.planning import run_certify

    return run_certify(plan, Output(json))


@app.command()
def validate(
    plan: Annotated[Path, typer.Argument(help="Plan file, with the motion of a robot.")],
    simulator: Annotated[str, typer.Option(help="pybullet or mujoco.")] = "pybullet",
    controller: Annotated[
        str, typer.Option(help="hybrid, admittance, position or feedforward.")
    ] = "hybrid",
    trials: Annotated[
        int, typer.Option(min=1, max=100_000, help="Number of trials; one is nominal.")
    ] = 1,
    seed: Seed = 0,
    perturbed: Annotated[
        bool | None,
        typer.Option("--perturbed/--nominal", help="Else: nominal if there is one trial only."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Processes at a time; else all cores.")
    ] = None,
    replan: Annotated[
        bool,
        typer.Option("--replan", help="After each addition plan the rest from measurements."),
    ] = False,
    replan_hold: Annotated[
        float, typer.Option(help="Simulated seconds the grasp is held meanwhile.")
    ] = 1.0,
    recover: Annotated[
        bool,
        typer.Option("--recover", help="In danger allocate forces anew, or put the finger back."),
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Record file to write.")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Carry a plan out in a physics simulator, once or in many perturbed trials.

    Example: `pivotgait validate knife.h5 --trials 100 -o record.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.validation import run_validate

    return run_validate(
        plan,
        simulator,
        controller,
        trials,
        seed,
        output,
        Output(json),
        perturbed=perturbed,
        workers=workers,
        recover=recover,
        replan_hold_s=replan_hold if replan else None,
    )


@app.command()
def baselines(
    plan: Annotated[Path, typer.Argument(help="Plan file, with the motion of a robot.")],
    simulator: Annotated[str, typer.Option(help="pybullet or mujoco.")] = "pybullet",
    trials: Annotated[
        int, typer.Option(min=1, max=100_000, help="Number of trials; one is nominal.")
    ] = 1,
    seed: Seed = 0,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Processes at a time; else all cores.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="JSON file to write.")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Try a plan with the same seeds under every control law, and without pivoting.

    Example: `pivotgait baselines knife.h5 --trials 100 -o baselines.json`
    """
    from pivotgait.commands.baselines import run_baselines_command
    from pivotgait.commands.output import Output

    return run_baselines_command(
        plan, simulator, trials, seed, output, Output(json), workers=workers
    )


@app.command()
def compare(
    plan: Annotated[Path, typer.Argument(help="Plan file, with the motion of a robot.")],
    trials: Annotated[
        int,
        typer.Option(min=0, max=100_000, help="Perturbed trials in each after the nominal run."),
    ] = 0,
    seed: Seed = 0,
    controller: Annotated[
        str, typer.Option(help="hybrid, admittance, position or feedforward.")
    ] = "hybrid",
    causes: Annotated[
        bool | None,
        typer.Option(
            "--causes/--no-causes",
            help="Repeat with step, contacts and friction changed; else: if they do not agree.",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Processes at a time; else all cores.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Folder for records and figure; a report's shows it."),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Carry a plan out in PyBullet and MuJoCo and tell how far the two agree.

    Example: `pivotgait compare reports/out/knife/plan.h5 --trials 100 -o reports/out/knife`
    """
    from pivotgait.commands.comparing import run_compare
    from pivotgait.commands.output import Output
    from pivotgait.validation import CompareOptions, RunOptions

    options = CompareOptions(
        run=RunOptions(controller=controller),
        trials=trials,
        seed=seed,
        causes=causes,
        workers=workers,
    )
    return run_compare(plan, options, output, Output(json))


@app.command()
def run(
    scene: SceneArgument,
    out: Annotated[Path, typer.Option("--out", help="Folder for plan, figures and report.")],
    seed: Seed = 0,
    gait: Gait = None,
    hand: Hand = True,
    view: Annotated[
        bool, typer.Option("--view/--no-view", help="Write view.html and run_view.html too.")
    ] = True,
    validate: Annotated[
        bool | None,
        typer.Option(
            "--validate/--no-validate",
            help="Carry the plan out in PyBullet; else: if it has a robot.",
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(min=0, max=100_000, help="Perturbed trials after the nominal run.")
    ] = 0,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Plan, certify, carry out in a simulator and report: the whole job in one command.

    Example: `pivotgait run knife --out reports/out/knife`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.reporting import ClosedLoop, run_all

    return run_all(
        scene,
        out,
        seed,
        gait,
        Output(json),
        hand=hand,
        view=view,
        closed_loop=ClosedLoop(validate, trials),
    )


@app.command()
def sweep(
    study: Annotated[
        str | None, typer.Argument(help="A built-in study's name or a YAML file.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for the results; goes on where it is.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Processes at a time; else all cores.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, like tcp://host:8786.")
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Tell the number of cells and the expected time.")
    ] = False,
    list_: Annotated[bool, typer.Option("--list", help="List the built-in studies.")] = False,
    export: Annotated[str | None, typer.Option(help="Print a built-in study's YAML.")] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Compute every cell of a study; killed at any moment, the same command goes on.

    Example: `pivotgait sweep knife_friction --out reports/out/friction`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.sweeping import run_sweep_command

    return run_sweep_command(
        study,
        out,
        workers,
        scheduler,
        Output(json),
        dry_run=dry_run,
        listed=list_,
        export=export,
    )


@app.command()
def feasibility(
    scene: SceneArgument,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="Change a parameter first, e.g. `contacts.*.friction=0.4`; may be repeated.",
        ),
    ] = None,
    gait: Gait = None,
    turn_max: Annotated[
        float | None,
        typer.Option(help="Largest turn of the tool in a removal [deg]; 0 for no pivoting."),
    ] = None,
    hand: Annotated[
        bool, typer.Option("--hand/--no-hand", help="Plan the arm-hand too; keep its torques.")
    ] = False,
    mends: Annotated[int, typer.Option(min=0, max=20, help="Most mends to look for.")] = 3,
    maps: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="PATH=LO:HI",
            help="A map in place of one verdict, over two parameters; a third gives slices, "
            "`removed=FINGER,FINGER` those without each finger.",
        ),
    ] = None,
    phase: Annotated[
        str | None,
        typer.Option(help="Of a map: after which phase; else the gait's first removal or lift."),
    ] = None,
    quantity: Annotated[str, typer.Option(help="Of a map: depth, margin or turn.")] = "depth",
    tolerance: Annotated[
        float | None, typer.Option(help="Of a map's border, share of an axis; else 1/128.")
    ] = None,
    spread: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=SD",
            help="Of a map: draw a parameter, and show the share of draws that hold, too.",
        ),
    ] = None,
    draws: Annotated[int, typer.Option(min=1, max=100_000, help="Of --spread, a point.")] = 64,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the map.")] = None,
    seed: Seed = 0,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Judge a gait: feasible or not, what binds, the nearest changes that mend it, the margins.

    Examples: `pivotgait feasibility knife`,
    `pivotgait feasibility knife --set 'contacts.*.friction=0.3'`,
    `pivotgait feasibility knife --set tool.mass_scale=4 --json`,
    `pivotgait feasibility knife --turn-max 0`,
    `pivotgait feasibility knife --map contacts.*.friction=0.2:1.2 --map tool.pitch_deg=10:50`
    """
    from pivotgait.commands.feasibility import run_feasibility
    from pivotgait.commands.output import Output
    from pivotgait.feasibility import VerdictOptions

    if maps:
        from pivotgait.commands.mapping import MapRequest, run_maps

        request = MapRequest(
            tuple(maps),
            gait,
            phase,
            quantity,
            turn_max,
            tolerance,
            tuple(spread or ()),
            draws,
            seed,
        )
        return run_maps(scene, changes or [], request, out, Output(json))
    options = VerdictOptions(gait, turn_max, hand, mends, seed=seed)
    return run_feasibility(scene, changes or [], options, Output(json))


@app.command()
def search(
    scene: SceneArgument,
    goal: Annotated[
        str,
        typer.Option(
            help="Wanted grasp: contacts of the scene or places like `index@0.03/180` (metres "
            "along the handle, degrees around it), all of them and no others; `power-grasp`, "
            "`power-grasp by thumb within 0.05 m`: a finger opposes two, and the palm is that near "
            "to the handle's axis; `lifted off by thumb_top and middle_below`, or by fingers.",
        ),
    ],
    first: Annotated[
        str | None, typer.Option(help="Contacts that lift the tool; else any two.")
    ] = None,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option("--out", help="Scene file to write.")] = None,
    sequences: Annotated[
        int, typer.Option(min=1, max=100, help="Find so many and take the cheapest.")
    ] = 1,
    time_limit: Annotated[
        float, typer.Option(min=1.0, max=86400.0, help="End after this time [s].")
    ] = 60.0,
    hand: Hand = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Find contacts and an order of gaits that lead to a wanted grasp, as a scene that replays.

    Examples: `pivotgait search knife --goal 'thumb_spine, middle_flat, index_edge_near'`,
    `pivotgait search knife --goal power-grasp --out power.yaml`, then `pivotgait plan power.yaml`,
    `pivotgait search knife --goal 'thumb@0.04/0, index@0.05/180, middle@0.03/180' --seed 1`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.searching import SearchRequest, run_search

    request = SearchRequest(goal, first, seed, out, sequences, time_limit, hand)
    return run_search(scene, request, Output(json))


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(help="Folder of a run or of a sweep.")],
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Draw the figures of a folder's plan or sweep and write its report.html (and report.pdf).

    Example: `pivotgait report reports/out/knife`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.reporting import run_report

    return run_report(folder, Output(json))


@app.command()
def view(
    plan: Annotated[Path, typer.Argument(help="Plan file.")],
    html: Annotated[
        Path | None, typer.Option(help="Write one HTML file that needs no network, and end.")
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the local server.")
    ] = None,
    browse: Annotated[bool, typer.Option("--open/--no-open", help="Open a browser.")] = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Show a plan as an animated scene: arm and hand, tool, forces and friction cones.

    Example: `pivotgait view knife.h5 --html knife.html`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.viewing import run_view

    return run_view(plan, html, port, browse, Output(json))


@app.command()
def scenes(
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the scenes' JSON schema.")
    ] = False,
    export: Annotated[str | None, typer.Option(help="Print a built-in scene's YAML.")] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """List the built-in scenes, or print one to start from.

    Example: `pivotgait scenes --export knife > my_knife.yaml`
    """
    from pivotgait.commands.inspection import run_scenes
    from pivotgait.commands.output import Output

    return run_scenes(schema, export, Output(json))


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A URDF, a scene (YAML) or a plan (HDF5).")],
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Check a URDF, a scene or a plan file before anything is computed with it.

    Example: `pivotgait check my_tool.urdf`
    """
    from pivotgait.commands.inspection import run_check
    from pivotgait.commands.output import Output

    return run_check(file, Output(json))


@app.command()
def doctor(json: Json = False, debug: Debug = False) -> int:
    """Check the environment: versions and one small job for each native library.

    Example: `pivotgait doctor`
    """
    from pivotgait.commands.doctor import run_doctor
    from pivotgait.commands.output import Output

    return run_doctor(Output(json))


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer repetitions.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Time the solvers against their peers, as ratios measured in one run.

    Example: `pivotgait bench --quick`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.timing import run_bench

    return run_bench(quick, Output(json))


def main(arguments: list[str] | None = None) -> None:
    """Entry point: 0 success, 1 infeasible or a failed check, 2 bad input, in one line each."""
    given = sys.argv[1:] if arguments is None else arguments
    try:
        code = app(args=given, standalone_mode=False)
        sys.stdout.flush()
    except (PivotGaitError, typer.TyperException) as error:
        if "--debug" in given:
            traceback.print_exc()
        code = _complain(error)
    except (KeyboardInterrupt, typer.Abort):
        sys.stderr.write("pivotgait: stopped\n")
        code = 130
    except (BrokenPipeError, SystemExit):  # typer exits with 1 where it meets a broken pipe
        # whoever read our output has gone: nothing more can be written, nor was all said, so
        # that this is no success; 141 is what the shell gives other programs then
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 141
    sys.exit(code or 0)


def _complain(error: PivotGaitError | typer.TyperException) -> int:
    text = error.format_message() if isinstance(error, typer.TyperException) else str(error)
    if text:  # empty where the help was printed instead
        hint = " (see pivotgait --help)" if isinstance(error, typer.TyperException) else ""
        sys.stderr.write(f"pivotgait: error: {' '.join(text.split())}{hint}\n")
    return error.exit_code
