"""Answers questions about the simulator's robot with MuJoCo: a line of JSON in, a line of JSON out.

A question is [name, arguments]; the answers to each are documented at the functions below. Angles are in the order of
the URDF's joints, matrices row by row, everything in the root frame, metres and radians.
"""

import json
import sys

import model
import mujoco
import numpy as np

# Length of a control step, s.
CONTROL_STEP = 0.05


def urdf(_):
    """What MuJoCo reads in the shipped URDF, unchanged: of every joint its name, limits, damping and largest torque;
    the mass of all links."""
    compiled = mujoco.MjModel.from_xml_path(str(model.URDF))
    return {
        "names": [compiled.joint(i).name for i in range(compiled.njnt)],
        "limits": compiled.jnt_range.tolist(),
        "damping": compiled.dof_damping.tolist(),
        "torques": compiled.jnt_actfrcrange[:, 1].tolist(),
        "mass": float(compiled.body_mass.sum()),
    }


def poses(postures):
    """For each posture: position and rotation of every moving link, the palm, tips of the fingers."""
    spec = model.robot()
    names = model.name_shapes(spec)
    compiled = spec.compile()
    data = mujoco.MjData(compiled)
    links = compiled.jnt_bodyid
    hand = compiled.geom_bodyid[compiled.geom(names["palm"][0]).id]
    tips = [compiled.geom(name).id for name in names["tips"]]
    answer = []
    for angles in postures:
        data.qpos[:] = angles
        mujoco.mj_kinematics(compiled, data)
        answer.append(
            {
                "positions": data.xpos[links].tolist(),
                "rotations": data.xmat[links].tolist(),
                "palm": (data.xpos[hand] + data.xmat[hand].reshape(3, 3) @ model.SETUP["palm"]).tolist(),
                "tips": [(data.geom_xpos[i] + compiled.geom_size[i][1] * axis(data, i, 2)).tolist() for i in tips],
            }
        )
    return answer


def axis(data, geom, number):
    return data.geom_xmat[geom].reshape(3, 3)[:, number]


def dynamics(states):
    """For each pair of angles and velocities: joint-space inertia, rotors included, and Coriolis and centrifugal
    forces."""
    compiled = model.robot().compile()
    data = mujoco.MjData(compiled)
    inertia = np.empty((compiled.nv, compiled.nv))
    answer = []
    for angles, velocities in states:
        data.qpos[:], data.qvel[:] = angles, velocities
        mujoco.mj_forward(compiled, data)
        mujoco.mj_fullM(compiled, data, inertia)
        answer.append({"inertia": inertia.flatten().tolist(), "bias": data.qfrc_bias.tolist()})
    return answer


def responses(cases):
    """For each case of integrator, step (s), start, targets and seconds: the angles after every control step while
    the servos, without anything to touch, drive the robot from rest."""
    answer = []
    for case in cases:
        spec = model.robot()
        model.add_servos(spec)
        model.add_stops(spec)
        spec.option.timestep = case["step"]
        spec.option.integrator = getattr(mujoco.mjtIntegrator, "mjINT_" + case["integrator"])
        compiled = spec.compile()
        data = mujoco.MjData(compiled)
        data.qpos[:], data.ctrl[:] = case["start"], case["targets"]
        course = []
        for _ in range(round(case["seconds"] / CONTROL_STEP)):
            mujoco.mj_step(compiled, data, round(CONTROL_STEP / case["step"]))
            course.append(data.qpos.tolist())
        answer.append(course)
    return answer


def rest(scenes):
    """For each scene of angles, object, orientation, friction and the servos' targets in each control step: angles,
    object and orientation in the end. The contacts are soft enough to bring out an overlap at the start gently, and
    stiff enough to yield less than 0.1 mm."""
    step = 1e-4
    contact = {"solref": [0.005, 1.0], "solimp": [0.999, 0.999, 0.001, 0.5, 2.0]}
    answer = []
    for scene in scenes:
        spec = model.scene(contact | {"friction": scene["friction"]})
        spec.option.timestep = step
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        # Without these a thing that friction holds would creep.
        spec.option.impratio = 10.0
        spec.option.noslip_iterations = 20
        compiled = spec.compile()
        data = mujoco.MjData(compiled)
        data.qpos[:] = scene["angles"] + scene["object"] + scene["orientation"]
        for targets in scene["commands"]:
            data.ctrl[:-1] = targets
            mujoco.mj_step(compiled, data, round(CONTROL_STEP / step))
        angles, thing, orientation = np.split(data.qpos, [20, 23])
        answer.append(
            {"angles": angles.tolist(), "object": thing.tolist(), "orientation": orientation.tolist()}
        )
    return answer


QUESTIONS = {function.__name__: function for function in [urdf, poses, dynamics, responses, rest]}


def main():
    for line in sys.stdin:
        name, arguments = json.loads(line)
        print(json.dumps(QUESTIONS[name](arguments)), flush=True)


if __name__ == "__main__":
    main()
