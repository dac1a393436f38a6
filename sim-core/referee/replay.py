"""Replays recorded motor commands in MuJoCo on one thread: the benchmark's opponent.

The argument names the settings. The first line of the input has the recordings; for every further one they are
replayed, and a line says where the objects end and how long it took. The time is that of MuJoCo's own loop in C
(mujoco.rollout), without Python's.
"""

import json
import sys
import time

import model
import mujoco
import numpy as np
from mujoco.rollout import Rollout

# Physics steps in a control step of 50 ms, as many as the simulator makes.
SUBSTEPS = 8
STEP = 0.05 / SUBSTEPS


def fastest():
    """Of what was tried, what took least time and stayed stable; README.md of the benchmark has the list."""
    contact = {"friction": model.SETUP["friction"], "solref": [2.0 * STEP, 1.0], "solimp": [0.9, 0.95, 0.001, 0.5, 2.0]}
    spec = model.scene(contact, may_roll=True, springs=False)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.option.iterations = 2
    spec.option.ls_iterations = 6
    return spec


def careful():
    """As close to the simulator's own scheme as MuJoCo comes with steps as long: servos and contacts implicit, stiff
    contacts, round cones."""
    contact = {"friction": model.SETUP["friction"], "solref": [STEP, 1.0], "solimp": [0.99, 0.99, 0.001, 0.5, 2.0]}
    spec = model.scene(contact, may_roll=True, springs=False)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    return spec


SETTINGS = {function.__name__: function for function in [fastest, careful]}


def batches(compiled, recordings):
    """Start states, controls and room for the results, for the trials of each length."""
    groups = {}
    for number, recording in enumerate(recordings):
        groups.setdefault(len(recording["commands"]), []).append(number)
    for numbers in groups.values():
        chosen = [recordings[number] for number in numbers]
        states = [[0.0] + r["angles"] + r["object"] + r["orientation"] + [0.0] * compiled.nv for r in chosen]
        commands = np.repeat([r["commands"] for r in chosen], SUBSTEPS, axis=1)
        # The last actuator is the object's weight and takes no command.
        controls = np.concatenate([commands, np.zeros((*commands.shape[:2], 1))], axis=2)
        yield numbers, np.array(states), controls, np.empty((*commands.shape[:2], len(states[0])))


def main():
    spec = SETTINGS[sys.argv[1]]()
    spec.option.timestep = STEP
    compiled = spec.compile()
    data = mujoco.MjData(compiled)
    recordings = json.loads(sys.stdin.readline())
    prepared = list(batches(compiled, recordings))
    ends = [None] * len(recordings)
    with Rollout(nthread=0) as rollout:
        for _ in sys.stdin:
            begin = time.perf_counter()
            for _, states, controls, room in prepared:
                rollout.rollout(compiled, data, states, controls, state=room)
            seconds = time.perf_counter() - begin
            for numbers, _, _, room in prepared:
                for number, course in zip(numbers, room):
                    ends[number] = course[-1][21:24].tolist()
            print(json.dumps({"ends": ends, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
