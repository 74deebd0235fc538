"""Runs one job in MigFlow: reads a JSON job, steps, and writes frames as rows of doubles.

Started by the `makadam` command as `migflow migflow_driver.py job.json`, where `migflow` is a Python with the package migflow.

Frames, progress and result are those of yade_driver.py. A wall is one body of triangles, in whose frame its corners stand still.
"""

import json
import math
import os
import sys
import time
from unittest.mock import MagicMock

# The reader of mesh files is loaded at import and is not used here.
sys.modules["gmsh"] = MagicMock()
import numpy as np
from migflow import scontact

with open(sys.argv[1]) as file:
    job = json.load(file)

problem = scontact.ParticleProblem(3)
# Names of materials before the coefficients: each new name clears the table.
names = ["m%d" % index for index in range(job["materials"])]
for name in names:
    problem.get_material_id(name)
for first, second, friction in job["pairs"]:
    problem.set_friction_coefficient(friction, names[first], names[second])

# Grains first, so that their numbers are the scene's.
for grain in job["grains"]:
    grain["mass"] = grain["density"] * 4 / 3 * math.pi * grain["radius"] ** 3
    body = problem.add_particle(grain["position"], grain["radius"], grain["mass"], names[grain["material"]])
    problem.body_velocity()[body] = grain["velocity"]
    problem.body_omega()[body] = grain["spin"]
grain_count = len(job["grains"])

# Wall of each body, triangle, segment and further particle, in the order in which they were added.
wall_of_body = {}
for index, wall in enumerate(job["walls"]):
    point = np.array(wall["point"])
    body = problem.add_body(point, 0, 0)
    wall_of_body[body] = index
    name = names[wall["material"]]
    for corners in wall["triangles"]:
        problem.add_triangle_to_body(*(np.array(corners) - point), body, name, name)
    # MigFlow's triangles have no edges of their own.
    for ends in wall["edges"]:
        problem.add_segment_to_body(*(np.array(ends) - point), body, name, name)
    for corner in wall["corners"]:
        problem.add_particle_to_body(np.array(corner) - point, 0.0, body, name)
    wall["body"] = body
wall_of = np.array([wall_of_body.get(body, -1) for body in range(problem.n_bodies())])
grain_bodies = problem.particle_body()[:grain_count].copy()
# Largest distance of a corner from the point about which its wall turns.
reach = max((np.linalg.norm(np.array(wall["triangles"]) - wall["point"], axis=2).max() for wall in job["walls"]), default=0.0)

forces = np.zeros((problem.n_particles(), 3))
forces[:grain_count] = np.outer([grain["mass"] for grain in job["grains"]], job["gravity"])


def move_walls(step):
    """Sets the velocities of moving walls for one step."""
    for wall in job["walls"]:
        for motion in wall["motions"]:
            # A phase that begins where another ends comes after it.
            if step == motion["last"]:
                problem.body_velocity()[wall["body"]] = problem.body_omega()[wall["body"]] = 0
            if not motion["first"] <= step < motion["last"]:
                continue
            rate = np.array(motion["axis"]) * motion["rate"]
            if motion["kind"] == "rotating":
                problem.body_omega()[wall["body"]] = rate
            elif motion["kind"] == "translating":
                problem.body_velocity()[wall["body"]] = rate
            else:
                turn = 2 * math.pi * motion["frequency"] * job["time_step"]
                ends = [math.sin(turn * (at - motion["first"])) for at in (step, step + 1)]
                problem.body_velocity()[wall["body"]] = rate * (ends[1] - ends[0]) / job["time_step"]


def set_range():
    """Lets candidates reach as far as two bodies may approach each other in a step: inelastic impacts make no body faster."""
    length = lambda vectors: np.linalg.norm(vectors, axis=1).max(initial=0.0)
    walls = [wall["body"] for wall in job["walls"]]
    of_grains = length(problem.body_velocity()[grain_bodies]) + np.linalg.norm(job["gravity"]) * job["time_step"]
    of_walls = length(problem.body_velocity()[walls]) + length(problem.body_omega()[walls]) * reach
    problem.contact_detection_d = job["slack"] + (of_grains + max(of_grains, of_walls)) * job["time_step"]


def contact_table():
    """Returns the contacts that carry a force, in the columns of a frame."""
    all_contacts = problem.contacts()
    contacts = all_contacts[(all_contacts["active"] == 1) & np.any(all_contacts["reaction"] != 0.0, axis=1)]
    body_of = problem.particle_body()
    partners = {0: body_of, 1: problem.segments()["body"], 2: problem.triangles()["body"]}
    rows = []
    for contact in contacts:
        # The reaction acts on the second; the normal leads from the first to the second.
        other, second = (int(number) for number in contact["o"])
        normal, force, arm = contact["basis"][0], contact["reaction"], contact["r"][1]
        partner = int(partners[int(contact["contact_type"])][other])
        if second >= grain_count:
            # A corner of a wall, which is a particle without radius.
            other, second, partner = second, other, int(body_of[second])
            normal, force, arm = -normal, -force, contact["r"][0]
        wall = wall_of[partner]
        at = problem.body_position()[grain_bodies[second]] + arm
        rows.append([second, float(wall >= 0), wall if wall >= 0 else other, *at, *-normal, *force])
    return np.array(rows, dtype="<f8").reshape(-1, 12)


def write_frame(output, step):
    contacts = contact_table() if step else np.zeros((0, 12))
    grains = [problem.body_position(), problem.body_velocity(), problem.body_omega()]
    np.array([step * job["time_step"], grain_count, len(contacts)], dtype="<f8").tofile(output)
    np.hstack([table[grain_bodies] for table in grains]).astype("<f8").tofile(output)
    contacts.tofile(output)


def write_text(name, text):
    with open(name + ".part", "w") as file:
        file.write(text)
    os.replace(name + ".part", name)


frames = set(job["frames"])
parent = os.getppid()
seconds = core_seconds = solve_seconds = 0.0
relaxations = unconverged = 0
with open("frames.bin", "wb") as output:
    for step in range(job["steps"] + 1):
        if step in frames:
            write_frame(output, step)
        if step % max(1, job["steps"] // 100) == 0:
            write_text("progress.txt", "%.6f" % (step / job["steps"]))
            if os.getppid() != parent:
                raise SystemExit("the program that started this run is gone")
        if step == job["steps"]:
            break
        start, core_start = time.perf_counter(), time.process_time()
        move_walls(step)
        set_range()
        # Grains move with the velocities of an unfinished solve, too, as Makadam's do.
        unconverged += not problem.iterate(job["time_step"], forces, tol=job["tolerance"], force_motion=1)
        seconds += time.perf_counter() - start
        core_seconds += time.process_time() - core_start
        relaxations += problem.get_iters_contacts_solve()
        solve_seconds += problem.get_time_contacts_solve()
print("%d contact relaxations in %g s, %d steps not converged" % (relaxations, solve_seconds, unconverged))
write_text("result.json", json.dumps({"seconds": seconds, "core_seconds": core_seconds, "steps": job["steps"]}))
