"""Runs a scene of spheres in boxes at rest in Siconos: `driver.py STEP TOLERANCE [assertions]` in the folder of a run.

Reads scene.json, grains.csv and frames.csv, and writes frames/grains-TIME.csv and frames/contacts-TIME.csv. Siconos steps with Moreau
and Jean's scheme and solves the contact problem of each step by projected Gauss-Seidel (NSGS) until the error of its own measure, relative
to the free velocities, is below a tolerance. Grains are rigid, restitution is Newton's, contacts are found by Bullet, walls are planes.
"""

import csv
import json
import math
import os
import subprocess
import sys
import time

STEP, TOLERANCE = float(sys.argv[1]), float(sys.argv[2])

# Debian's assertions walk whole graphs for each contact: a library that is loaded first turns these off.
if "assertions" not in sys.argv and "LD_PRELOAD" not in os.environ:
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "assertions_off.c")
    library = os.path.abspath("assertions_off.so")
    subprocess.run([os.environ.get("CC", "cc"), "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    os.environ["LD_PRELOAD"] = library
    os.execv(sys.executable, [sys.executable, *sys.argv])

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

# Iterations at which a solve is given up.
MOST_ITERATIONS = 10_000

with open("scene.json") as file:
    scene = json.load(file)
with open("grains.csv") as file:
    grains = list(csv.DictReader(file))
with open("frames.csv") as file:
    times = [float(row["time"]) for row in csv.DictReader(file)]
steps = round(scene["duration"] / STEP)


def refuse(reason):
    sys.exit(f"Error: Siconos cannot express this scene: {reason}")


def coefficients():
    """Friction and restitution, which are the same at all contacts: one law is given to Siconos."""
    materials = scene["material"].values()
    for key, usual in [("rolling_friction", 0.0), ("twisting_friction", 0.0), ("cohesion", None)]:
        if any((material.get(key) or usual) != usual for material in materials):
            refuse(f"it has {key}")
    pairs = {(material["friction"], material["restitution"]) for material in materials}
    if len(pairs) != 1 or scene.get("pair"):
        refuse("friction or restitution differ from contact to contact")
    return pairs.pop()


def planes():
    """Closed faces of all boxes: number of the wall, a point, the unit vector into the box."""
    found = []
    for number, wall in enumerate(scene["wall"]):
        shape, motion = wall["shape"], wall.get("motion") or {"kind": "fixed"}
        if shape["kind"] != "box" or motion["kind"] != "fixed":
            refuse(f"the wall {wall['name']} is not a box at rest")
        for axis in range(3):
            for inward, face, sign in [(1.0, shape["min"], "-"), (-1.0, shape["max"], "+")]:
                if sign + "xyz"[axis] not in (shape.get("open") or []):
                    normal = [0.0, 0.0, 0.0]
                    normal[axis] = inward
                    found.append({"wall": number, "point": face, "normal": normal})
    return found


PLANES = planes()


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
    friction, restitution = coefficients()
    manager.insertNonSmoothLaw(kernel.NewtonImpactFrictionNSL(restitution, 0.0, friction, 3), 0, 0)
    return manager


def contact_problem():
    """Friction-contact problem, solved by projected Gauss-Seidel until its error is below the tolerance."""
    problem = kernel.FrictionContact(3, numerics.SICONOS_FRICTION_3D_NSGS)
    options = problem.numericsSolverOptions()
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = MOST_ITERATIONS
    options.dparam[numerics.SICONOS_DPARAM_TOL] = TOLERANCE
    problem.setMaxSize(30000)
    problem.setMStorageType(numerics.NM_SPARSE_BLOCK)
    problem.setNumericsVerboseMode(False)
    # The last step's impulses are where a solve starts.
    problem.setKeepLambdaAndYState(True)
    return problem, options


def build():
    # The last event lies a step before the end that a time discretisation is given.
    system = kernel.NonSmoothDynamicalSystem(0.0, (steps + 2) * STEP)
    bodies = []
    for grain in grains:
        number = {name: float(value) for name, value in grain.items() if name != "material"}
        mass = number["density"] * 4.0 / 3.0 * math.pi * number["radius"] ** 3
        radius = number["radius"] / UNIT
        inertia = 0.4 * mass * radius * radius
        position = [number[name] / UNIT for name in ("x", "y", "z")] + [1.0, 0.0, 0.0, 0.0]
        velocity = [number[name] / UNIT for name in ("vx", "vy", "vz")] + [number[name] for name in ("wx", "wy", "wz")]
        body = RigidBodyDS(position, velocity, mass, np.eye(3) * inertia)
        contactors = SiconosContactorSet()
        contactors.append(SiconosContactor(SiconosSphere(radius)))
        body.setContactors(contactors)
        body.setFExtPtr([mass * value / UNIT for value in scene["gravity"]])
        system.insertDynamicalSystem(body)
        bodies.append(body)
    manager = bullet()
    for plane in PLANES:
        contactors = SiconosContactorSet()
        contactors.append(SiconosContactor(SiconosPlane()))
        position = [value / UNIT for value in plane["point"]] + plane_orientation(plane["normal"])
        manager.insertStaticContactorSet(contactors, position)
    problem, options = contact_problem()
    simulation = kernel.TimeStepping(system, kernel.TimeDiscretisation(0.0, STEP))
    simulation.insertIntegrator(kernel.MoreauJeanOSI(0.50001))
    simulation.insertNonSmoothProblem(problem)
    simulation.insertInteractionManager(manager)
    # A sphere's equations of motion are linear: one Newton iteration solves them.
    simulation.setNewtonOptions(kernel.SICONOS_TS_LINEAR)
    simulation.setNewtonMaxIteration(1)
    simulation.setNewtonTolerance(1e-10)
    return system, bodies, manager, simulation, options


def write(name, number, head, rows):
    with open(f"frames/{name}-{number * STEP:.9g}.csv", "w") as output:
        table = csv.writer(output)
        table.writerow(head)
        table.writerows(rows)


def contact_rows(system, bodies, number_of):
    """Contacts with their forces: impulses over the step. A contact with a plane has one body for both."""
    points = MechanicsIO().contactPoints(system, 1)
    rows = []
    for point in [] if points is None else np.atleast_2d(points):
        if point.size == 0:
            continue
        # Impulse on the first body, kg cm/s.
        force = point[10:13] * UNIT / STEP
        if not force.any():
            continue
        first, second = number_of[int(point[-2])], number_of[int(point[-1])]
        contact = point[1:4] * UNIT
        partner = (-1, wall_at(contact)) if first == second else (second, -1)
        rows.append([first, *partner, *contact, *force])
    return rows


def wall_at(point):
    """Wall whose plane lies nearest to a contact point, or farthest above it."""
    return min(PLANES, key=lambda plane: np.dot(plane["normal"], point - np.array(plane["point"])))["wall"]


def write_frame(number, system, bodies, number_of):
    rows = []
    for place, body in enumerate(bodies):
        velocity = np.array(body.twist())
        # Siconos has spins in the body's own frame.
        spin = rotation_matrix(body.q()[3:7]) @ velocity[3:]
        radius = grains[place]["radius"]
        rows.append([place, *(np.array(body.q()[:3]) * UNIT), radius, *(velocity[:3] * UNIT), *spin])
    write("grains", number, "id x y z radius vx vy vz wx wy wz".split(), rows)
    contacts = contact_rows(system, bodies, number_of) if number > 0 else []
    write("contacts", number, "first second wall px py pz fx fy fz".split(), contacts)


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
    frames = {round(moment / STEP) for moment in times}
    os.makedirs("frames", exist_ok=True)
    seconds, iterations, unsolved = 0.0, 0, 0
    if 0 in frames:
        write_frame(0, system, bodies, number_of)
    for number in range(1, steps + 1):
        start = time.perf_counter()
        simulation.computeOneStep()
        seconds += time.perf_counter() - start
        # After the solve and before the state is put aside, contacts have their impulses.
        if number in frames:
            write_frame(number, system, bodies, number_of)
        iterations += options.iparam[numerics.SICONOS_IPARAM_ITER_DONE]
        unsolved += options.dparam[numerics.SICONOS_DPARAM_RESIDU] > TOLERANCE
        start = time.perf_counter()
        simulation.clearNSDSChangeLog()
        simulation.nextStep()
        seconds += time.perf_counter() - start
    print(f"{seconds:.3f} s of stepping, {iterations / steps:.1f} iterations per step, {unsolved} steps above the tolerance")


run()
