"""The simulator's robot, table and object as a MuJoCo model.

The robot comes from the shipped URDF, as MuJoCo itself reads it; what a URDF cannot say, and the scene, from setup.toml.
"""

import tomllib
from pathlib import Path

import mujoco
import numpy as np

URDF = Path(__file__).parent.parent / "assets" / "icub-left-arm.urdf"
SETUP = tomllib.loads((Path(__file__).parent / "setup.toml").read_text())

# A joint's stop is so many times stiffer than its servo.
STOP_STIFFNESS = 100.0
# Half the thickness of the disc that stands for the object's base, m.
DISC = 1e-3


def robot():
    """The robot with its rotors, in empty space and without weight. Its parts do not touch each other."""
    spec = mujoco.MjSpec.from_file(str(URDF))
    spec.option.gravity = [0.0, 0.0, 0.0]
    for joint in spec.joints:
        joint.armature = servo(joint)["armature"]
        joint.limited = False
    spec.compiler.discardvisual = False
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0
    return spec


def servo(joint):
    return next(servo for servo in SETUP["servos"] if joint.name.startswith(servo["prefix"]))


def add_servos(spec):
    """Position actuators. The URDF has their damping and their largest torque."""
    for joint in spec.joints:
        actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=servo(joint)["stiffness"])
        actuator.forcelimited = True
        actuator.forcerange = joint.actfrcrange


def add_stops(spec):
    """The simulator's stops: springs that begin at the joints' limits."""
    for joint in spec.joints:
        stop = spec.add_tendon(name=joint.name, springlength=joint.range)
        stop.wrap_joint(joint.name, 1.0)
        stop.stiffness[0] = STOP_STIFFNESS * servo(joint)["stiffness"]


def name_shapes(spec):
    """Names each shape by its link and says which is what. Two capsules that continue each other behind a fixed joint
    become one, as they do in the simulator."""
    names = {"palm": [], "tips": [], "phalanges": [], "forearm": []}
    for body in list(spec.bodies):
        for geom in list(body.geoms):
            geom.name = body.name
            if geom.type == mujoco.mjtGeom.mjGEOM_BOX:
                names["palm"].append(geom.name)
            elif body.name.endswith("_3"):
                continued = body.parent.geoms[0]
                start, _ = ends(continued)
                _, end = ends(geom)
                end = body.pos + turned(body.quat, end)
                continued.pos = (start + end) / 2.0
                continued.size[1] = np.linalg.norm(end - start) / 2.0
                spec.delete(geom)
                names["tips"].append(continued.name)
            elif body.name.endswith("_1"):
                names["phalanges"].append(geom.name)
            elif body.name.endswith("_forearm"):
                names["forearm"].append(geom.name)
    return names


def ends(geom):
    """Both ends of a capsule's axis, in its body's frame."""
    half = turned(geom.quat, [0.0, 0.0, geom.size[1]])
    return geom.pos - half, geom.pos + half


def turned(quat, vector):
    result = np.empty(3)
    mujoco.mju_rotVecQuat(result, vector, quat)
    return result


def add_object(spec, may_roll):
    """A ball for the robot; for the table a disc as the ball's flat base and, if it may roll off the base, a sphere
    within the ball that touches base and top. Returns the names of the table's shapes."""
    thing = SETUP["object"]
    radius, base = thing["radius"], thing["base"]
    body = spec.worldbody.add_body(name="object", mass=thing["mass"], inertia=[thing["inertia"]] * 3)
    body.explicitinertial = True
    body.add_freejoint(name="object")
    rim = np.sqrt(radius**2 - base**2)
    sphere, cylinder = mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER
    shapes = {"ball": (sphere, [radius, 0.0, 0.0], 0.0), "base": (cylinder, [rim, DISC, 0.0], DISC - base)}
    if may_roll:
        shapes["round"] = (sphere, [(radius + base) / 2.0, 0.0, 0.0], (radius - base) / 2.0)
    for name, (kind, size, height) in shapes.items():
        geom = body.add_geom(name=name, type=kind, size=size, pos=[0.0, 0.0, height])
        geom.contype = geom.conaffinity = geom.mass = 0
    return [name for name in shapes if name != "ball"]


def add_weight(spec):
    """The weight of the object. The robot's is compensated, so there is no other gravity."""
    weight = spec.add_actuator(name="weight", target="object", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    weight.gear = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    weight.gainprm[0] = 0.0
    weight.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    weight.biasprm[0] = -SETUP["object"]["mass"] * SETUP["gravity"]


def scene(contact, may_roll=False, springs=True):
    """Robot, table and object. The pairs of shapes that can touch are the simulator's; `contact` has friction, solref
    and solimp of all. Stops are the simulator's springs or MuJoCo's limits."""
    spec = robot()
    add_servos(spec)
    if springs:
        add_stops(spec)
    else:
        for joint in spec.joints:
            joint.limited = True
    parts = name_shapes(spec)
    lying = add_object(spec, may_roll)
    add_weight(spec)
    table = spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0])
    table.pos = [0.0, 0.0, SETUP["table"]]
    table.contype = table.conaffinity = 0
    outer = parts["palm"] + parts["tips"] + parts["forearm"]
    pairs = [("table", name) for name in lying + outer] + [("ball", name) for name in outer + parts["phalanges"]]
    for first, second in pairs:
        pair = spec.add_pair(geomname1=first, geomname2=second, condim=3)
        pair.friction = [contact["friction"], contact["friction"], 0.0, 0.0, 0.0]
        pair.solref[:2] = contact["solref"]
        pair.solimp[:] = contact["solimp"]
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    return spec
