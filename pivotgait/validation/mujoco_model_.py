"""The world as a MuJoCo model, from the same URDF texts as every other engine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pivotgait.models.robot_parts import write
from pivotgait.models.urdf.nodes import read_nodes
from pivotgait.validation.link_pairs import quiet_pairs
from pivotgait.validation.simulator import SimulatorOptions
from pivotgait.validation.spring_contact import soft_constraint
from pivotgait.validation.undamped import undamped
from pivotgait.validation.world import World

ROBOT, TOOL, TABLE = "robot/", "tool/", "table"
"""Prefixes of the names of links and joints, and the name of the table's geom."""
_SLASH = "/"
_IMPEDANCE_RATIO = 1e4
"""Of friction to normal. MuJoCo's friction creeps at F / (ratio (B + h K)) under a force F: 2 um/s
at 2 N on contacts of 20 kN/m; a ratio of 10 lets the tool's tip creep away during the lift."""
_PYRAMIDAL_IMPEDANCE_RATIO = 100.0
"""The same of pyramidal cones, whose normal softness MuJoCo divides by it, too: with 1e4 contacts
are so stiff that the tool is thrown during the lift, with 10 the fingertips creep."""
_TOLERANCE = 1e-12


def build_model(world: World, options: SimulatorOptions) -> Any:
    """A compiled ``mujoco.MjModel``: the table, the robot fixed in the world, the tool free.

    Fingertips on the tool and the tool on the table are explicit pairs with their own friction
    and stiffness; all other contacts are hard, with a coefficient of 1.
    """
    import mujoco

    spec = mujoco.MjSpec()
    # Tips are links fixed to others: they keep their names and shapes.
    spec.compiler.fusestatic = False
    _set_engine(spec, world, options)
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name=TABLE, type=plane, size=[0, 0, 1], pos=[0, 0, world.table_height])
    _attach(spec, world.robot_urdf, ROBOT)
    root = _attach(spec, world.tool_urdf, TOOL)
    spec.body(root).add_freejoint()
    _name_geoms(spec)
    _set_pairs(spec, world, root)
    model = spec.compile()
    _set_contacts(model, options)
    _set_joints(model, world, options)
    return model


def _set_engine(spec: Any, world: World, options: SimulatorOptions) -> None:
    import mujoco

    option = spec.option
    option.timestep = options.step_s
    option.gravity = world.gravity
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    cones = mujoco.mjtCone
    elliptic = options.friction_cone == "elliptic"
    option.cone = cones.mjCONE_ELLIPTIC if elliptic else cones.mjCONE_PYRAMIDAL
    option.impratio = _IMPEDANCE_RATIO if elliptic else _PYRAMIDAL_IMPEDANCE_RATIO
    # The sparse Newton solver of 4.0.0 may use a wrong Hessian (issue #3767, mended in 4.0.1).
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    option.iterations = options.solver_iterations
    option.tolerance = _TOLERANCE
    # A run that diverges must be seen to, not silently start anew.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET


def _attach(spec: Any, urdf: str, prefix: str) -> str:
    """Add the bodies of a URDF text; returns the name of its root."""
    import mujoco

    child = mujoco.MjSpec.from_string(slashed(undamped(urdf)))
    child.compiler.fusestatic = False
    root = child.worldbody.first_body().name
    name = prefix.removesuffix(_SLASH)
    spec.attach(child, prefix=name, frame=spec.worldbody.add_frame())
    return f"{name}{root}"


def slashed(urdf: str) -> str:
    """URDF text with a slash before every link's and joint's name.

    MuJoCo takes a link called ``world``, wherever it is, for the world itself.
    """
    robot = read_nodes(urdf, where="robot or tool of the plan")
    for node in (*robot.all("link"), *robot.all("joint")):
        node.attributes["name"] = f"{_SLASH}{node.attributes['name']}"
        for end in (*node.all("parent"), *node.all("child")):
            end.attributes["link"] = f"{_SLASH}{end.attributes['link']}"
    return write(robot)


def _name_geoms(spec: Any) -> None:
    """Names of one's own: those of a URDF's collisions need not be unique."""
    for body in spec.bodies[1:]:
        for place, geom in enumerate(body.geoms):
            geom.name = f"{body.name}/{place}"
            geom.condim, geom.friction = 3, [1.0, 0.0, 0.0]


def _set_pairs(spec: Any, world: World, tool: str) -> None:
    shapes = _names(spec.body(tool).geoms)
    for name, finger in world.fingers.items():
        tip = _names(spec.body(f"{ROBOT}{finger.tip_frame}").geoms)
        friction, torsion = world.finger_friction[name], world.finger_torsion.get(name, 0.0)
        _add_pairs(spec, tip, shapes, friction, torsion)
    _add_pairs(spec, (TABLE,), shapes, world.table_friction, 0.0)
    for one, other in quiet_pairs(world.robot_urdf, world.never_touch).among:
        spec.add_exclude(bodyname1=f"{ROBOT}{one}", bodyname2=f"{ROBOT}{other}")


def _names(geoms: Iterable[Any]) -> tuple[str, ...]:
    return tuple(geom.name for geom in geoms)


def _add_pairs(
    spec: Any, ones: Iterable[str], others: tuple[str, ...], friction: float, torsion: float
) -> None:
    """Pairs of geoms; with torsional friction [m] a contact has a fourth dimension."""
    values, condim = [friction, friction, torsion, 0.0, 0.0], 4 if torsion > 0.0 else 3
    for one in ones:
        for other in others:
            spec.add_pair(geomname1=one, geomname2=other, condim=condim, friction=values)


def _set_contacts(model: Any, options: SimulatorOptions) -> None:
    """Stiffness of the pairs, known once MuJoCo has weighed the bodies; the rest is hard."""
    hard = soft_constraint(None, 0.0, options.step_s, 1.0)
    model.geom_solref[:], model.geom_solimp[:, :3] = hard.solref, hard.solimp
    weights = model.body_invweight0[:, 0]
    for pair in range(model.npair):
        geoms = model.pair_geom1[pair], model.pair_geom2[pair]
        inverse_mass = sum(weights[model.geom_bodyid[geom]] for geom in geoms)
        contact = soft_constraint(
            options.contact_stiffness, options.contact_damping, options.step_s, inverse_mass
        )
        model.pair_solref[pair], model.pair_solimp[pair, :3] = contact.solref, contact.solimp


def _set_joints(model: Any, world: World, options: SimulatorOptions) -> None:
    """Hard limits; dry friction that does not creep."""
    hard = soft_constraint(None, 0.0, options.step_s, 1.0)
    model.jnt_solref[:], model.jnt_solimp[:, :3] = hard.solref, hard.solimp
    for name, friction in zip(world.joint_names, world.joint_friction, strict=True):
        dof = model.joint(f"{ROBOT}{name}").dofadr[0]
        model.dof_frictionloss[dof] = friction
        model.dof_solref[dof], model.dof_solimp[dof, :3] = hard.solref, (0.9999, 0.9999, 1e-3)


def write_no_log() -> None:
    """Keep MuJoCo from writing its warnings to a file in the user's folder."""
    import mujoco

    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_ignore)


def _ignore(_: str) -> None:
    """What MuJoCo warns of shows in the state, which the run watches."""
