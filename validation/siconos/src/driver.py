"""Runs one job in Siconos: reads a JSON job, steps, and writes frames as rows of doubles.

Started by `makadam-siconos` as `python3 driver.py job.json` in the folder of the job. Frames are those of
`validation/src/peers/yade_driver.py`: time, number of grains, number of contacts; then for each grain x y z vx vy vz wx wy wz; then for
each contact: id of the first grain, 0 or 1 for a grain or a wall, id of the partner, point (3), normal from the first grain to
the partner (3), force on the first grain (3). Little-endian.
"""

import json
import math
import sys
import time
from array import array

import numpy as np
import siconos.kernel as kernel
import siconos.numerics as numerics
from siconos.io.io_base import MechanicsIO
from siconos.mechanics.collision import (
    RigidBodyDS,
    SiconosContactor,
    SiconosContactorSet,
    SiconosPlane,
    SiconosSphere,
)
from siconos.mechanics.collision.bullet import SiconosBulletCollisionManager, SiconosBulletOptions

# Bullet's margins are made for objects of about a metre: lengths are given to Siconos in centimetres.
UNIT = 0.01

with open(sys.argv[1]) as file:
    job = json.load(file)


def plane_orientation(normal):
    """Quaternion that turns the z axis, along which a plane's normal points, to a normal along an axis."""
    x, y, z = normal
    half = math.sqrt(0.5)
    if z > 0.5:
        return [1.0, 0.0, 0.0, 0.0]
    if z < -0.5:
        return [0.0, 1.0, 0.0, 0.0]
    # A quarter turn about z x normal.
    return [half, -half * y, half * x, 0.0]


def bullet():
    """Bullet with one contact point a pair: between a sphere and anything else there is no other."""
    options = SiconosBulletOptions()
    options.worldScale = 1.0
    options.perturbationIterations = 0
    options.minimumPointsPerturbationThreshold = 0
    manager = SiconosBulletCollisionManager(options)
    manager.insertNonSmoothLaw(
        kernel.NewtonImpactFrictionNSL(job["restitution"], 0.0, job["friction"], 3), 0, 0
    )
    return manager


def contact_problem():
    """Friction-contact problem, solved by projected Gauss-Seidel until its error is below the tolerance."""
    problem = kernel.FrictionContact(3, numerics.SICONOS_FRICTION_3D_NSGS)
    options = problem.numericsSolverOptions()
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = job["most_iterations"]
    options.dparam[numerics.SICONOS_DPARAM_TOL] = job["tolerance"]
    problem.setMaxSize(30000)
    problem.setMStorageType(numerics.NM_SPARSE_BLOCK)
    problem.setNumericsVerboseMode(False)
    # The last step's impulses are where a solve starts.
    problem.setKeepLambdaAndYState(True)
    return problem, options


def build():
    steps, step = job["steps"], job["time_step"]
    # The last event lies a step before the end that a time discretisation is given.
    system = kernel.NonSmoothDynamicalSystem(0.0, (steps + 2) * step)
    bodies = []
    for grain in job["grains"]:
        radius, mass = grain["radius"] / UNIT, grain["mass"]
        inertia = 0.4 * mass * radius * radius
        position = [value / UNIT for value in grain["position"]] + [1.0, 0.0, 0.0, 0.0]
        velocity = [value / UNIT for value in grain["velocity"]] + list(grain["spin"])
        body = RigidBodyDS(position, velocity, mass, np.eye(3) * inertia)
        contactors = SiconosContactorSet()
        contactors.append(SiconosContactor(SiconosSphere(radius)))
        body.setContactors(contactors)
        body.setFExtPtr([mass * value / UNIT for value in job["gravity"]])
        system.insertDynamicalSystem(body)
        bodies.append(body)
    manager = bullet()
    for plane in job["planes"]:
        contactors = SiconosContactorSet()
        contactors.append(SiconosContactor(SiconosPlane()))
        position = [value / UNIT for value in plane["point"]] + plane_orientation(plane["normal"])
        manager.insertStaticContactorSet(contactors, position)
    problem, options = contact_problem()
    simulation = kernel.TimeStepping(system, kernel.TimeDiscretisation(0.0, step))
    simulation.insertIntegrator(kernel.MoreauJeanOSI(0.50001))
    simulation.insertNonSmoothProblem(problem)
    simulation.insertInteractionManager(manager)
    # A sphere's equations of motion are linear: one Newton iteration solves them.
    simulation.setNewtonOptions(kernel.SICONOS_TS_LINEAR)
    simulation.setNewtonMaxIteration(1)
    simulation.setNewtonTolerance(1e-10)
    return system, bodies, manager, simulation, options


def write(output, rows):
    table = array("d", rows)
    if sys.byteorder == "big":
        table.byteswap()
    table.tofile(output)


def contact_rows(system, bodies, number_of):
    """Contacts with their forces: impulses over the step. A contact with a plane has one body for both."""
    points = MechanicsIO().contactPoints(system, 1)
    rows = []
    for point in [] if points is None else np.atleast_2d(points):
        if point.size == 0:
            continue
        # Impulse on the first body, kg cm/s.
        force = point[10:13] * UNIT / job["time_step"]
        if not force.any():
            continue
        first, second = number_of[int(point[-2])], number_of[int(point[-1])]
        here = np.array(bodies[first].q()[:3])
        contact = point[1:4]
        if first == second:
            wall, normal = nearest_plane(here)
            partner = (1.0, wall)
        else:
            normal = np.array(bodies[second].q()[:3]) - here
            normal /= np.linalg.norm(normal)
            partner = (0.0, second)
        rows.append([first, *partner, *(contact * UNIT), *normal, *force])
    return rows


def nearest_plane(centre):
    """Wall and outward normal of the plane that a grain lies on; distances in Siconos' unit."""
    def distance(plane):
        return float(np.dot(plane["normal"], centre - np.array(plane["point"]) / UNIT))

    plane = min(job["planes"], key=distance)
    return plane["wall"], -np.array(plane["normal"])


def write_frame(output, step, system, bodies, number_of):
    contacts = contact_rows(system, bodies, number_of) if step > 0 else []
    write(output, (step * job["time_step"], len(bodies), len(contacts)))
    for body in bodies:
        velocity = body.twist()
        rotation = rotation_matrix(body.q()[3:7])
        # Siconos has spins in the body's own frame.
        write(output, [*(np.array(body.q()[:3]) * UNIT), *(np.array(velocity[:3]) * UNIT), *(rotation @ velocity[3:])])
    for row in contacts:
        write(output, row)


def rotation_matrix(quaternion):
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def run():
    system, bodies, manager, simulation, options = build()
    number_of = {body.number(): place for place, body in enumerate(bodies)}
    frames = set(job["frames"])
    seconds, iterations, unsolved, solves = 0.0, 0, 0, 0
    with open("frames.bin", "wb") as output:
        write_frame(output, 0, system, bodies, number_of)
        for step in range(1, job["steps"] + 1):
            start = time.perf_counter()
            simulation.computeOneStep()
            seconds += time.perf_counter() - start
            # After the solve and before the state is put aside, contacts have their impulses.
            if step in frames:
                write_frame(output, step, system, bodies, number_of)
            error = options.dparam[numerics.SICONOS_DPARAM_RESIDU]
            solves += 1
            iterations += options.iparam[numerics.SICONOS_IPARAM_ITER_DONE]
            unsolved += error > job["tolerance"]
            start = time.perf_counter()
            simulation.clearNSDSChangeLog()
            simulation.nextStep()
            seconds += time.perf_counter() - start
    with open("result.json", "w") as file:
        json.dump(
            {
                "seconds": seconds,
                "steps": job["steps"],
                "iterations_a_step": iterations / solves,
                "unsolved": int(unsolved),
            },
            file,
        )


run()
