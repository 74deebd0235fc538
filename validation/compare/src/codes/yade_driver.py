"""Runs one job in YADE: reads a JSON job, steps, and writes frames as rows of doubles.

Started by the `makadam` command as `yade -j1 -n -x yade_driver.py job.json`.

A frame is: time, number of grains, number of contacts; then for each grain
x y z vx vy vz wx wy wz; then for each contact: id of the first grain, 0 or 1 for a grain or a wall, id of the
partner, point (3), normal from the first grain to the partner (3), force on the first grain (3). Little-endian.
Beside the frames stands displacement and speed of each driven wall, frame after frame.
"""

import json
import math
import os
import sys
import time
import traceback
from array import array

with open(sys.argv[1]) as file:
    job = json.load(file)

O.dt = job["time_step"]

# Materials; a pair's friction and restitution come from tables, not from the materials' own values.
def append_material(m):
    return O.materials.append(
        FrictMat(young=m["young"], poisson=m["poisson"], density=m["density"], frictionAngle=0.0)
    )


materials = [append_material(m) for m in job["materials"]]
friction = [(materials[a], materials[b], angle) for a, b, angle, _ in job["pairs"]]
restitution = [(materials[a], materials[b], e) for a, b, _, e in job["pairs"]]
# Tangential damping follows the normal one, as the code has it, but for curved walls: a grain that slips from facet to facet would be
# damped by each new one without a cap until its spring is as strong as friction.
tangential = list(restitution)
curved = {}
for index in sorted({wall["material"] for wall in job["walls"] if wall["curved"]}):
    curved[index] = append_material(job["materials"][index])
    for a, b, angle, e in job["pairs"]:
        if index in (a, b):
            pair = (materials[a + b - index], curved[index])
            friction.append((*pair, angle))
            restitution.append((*pair, e))
            tangential.append((*pair, 1.0))

# Rolling resistance and cohesion: one number each for all contacts.
effects = job["rolling"] or {}
if job["cohesion"]:
    effects = effects | {"gamma": job["cohesion"]}

# Grains first, so that their ids in YADE are the scene's.
for grain in job["grains"]:
    body = sphere(grain["position"], grain["radius"], material=materials[grain["material"]])
    body.state.vel = grain["velocity"]
    body.state.angVel = grain["spin"]
    O.bodies.append(body)
grain_count = len(job["grains"])

wall_of = {}
motions = []
belts = []
drives = []
for index, wall in enumerate(job["walls"]):
    material = (curved if wall["curved"] else materials)[wall["material"]]
    ids = [
        O.bodies.append(facet([Vector3(*corner) for corner in triangle], material=material))
        for triangle in wall["triangles"]
    ] + [O.bodies.append(utils.wall(at, axis=axis, sense=0, material=material)) for axis, at in wall["planes"]]
    for id in ids:
        wall_of[id] = index
    for motion in wall["motions"] if ids else []:
        if motion["kind"] == "translating":
            engine = TranslationEngine(
                translationAxis=motion["axis"], velocity=motion["rate"], ids=ids, dead=True
            )
        elif motion["kind"] == "vibrating":
            # Its velocity is -A w sin(w t + fi) with the time of the run: A w cos(w (t - start)) here.
            phase = -2 * math.pi * motion["frequency"] * motion["first"] * job["time_step"] - math.pi / 2
            engine = HarmonicMotionEngine(
                A=Vector3(*motion["axis"]) * motion["rate"],
                f=Vector3(1, 1, 1) * motion["frequency"],
                fi=Vector3(1, 1, 1) * phase,
                ids=ids,
                dead=True,
            )
        else:
            # The engine moves bodies along the circle itself, not along its tangent: no drift over many turns.
            engine = RotationEngine(
                rotateAroundZero=True,
                zeroPoint=motion["point"],
                rotationAxis=motion["axis"],
                angularVelocity=motion["rate"],
                ids=ids,
                dead=True,
            )
        motions.append((engine, motion["first"], motion["last"], ids))
    if wall["belt"]:
        belts += [(O.bodies[id].state, Vector3(O.bodies[id].state.pos)) for id in ids]
        for id in ids:
            O.bodies[id].state.vel = Vector3(*wall["belt"])
    if wall["drive"]:
        drives.append(dict(wall["drive"], axis=Vector3(*wall["drive"]["axis"]), ids=ids, displacement=0.0, rate=0.0))


def drive_walls():
    """Moves driven walls as Newton's law and the forces of their contacts have it."""
    for drive in drives:
        if O.iter < drive["first"]:
            continue
        push = sum((O.forces.f(id) for id in drive["ids"]), Vector3.Zero)
        force = drive["force"] + (push + Vector3(*job["gravity"]) * drive["mass"]).dot(drive["axis"])
        drive["rate"] += O.dt * force / drive["mass"]
        drive["displacement"] += O.dt * drive["rate"]
        for id in drive["ids"]:
            O.bodies[id].state.vel = drive["axis"] * drive["rate"]


def hold_belts():
    """Puts belts back: the integrator moves them, contacts need their velocity alone."""
    for state, place in belts:
        state.pos = place


def set_rolling_stiffness():
    """Makes each rolling spring as stiff as the contact's tangential spring times the effective radius squared."""
    for contact in O.interactions:
        if contact.isReal:
            first, second = contact.geom.refR1, contact.geom.refR2
            at_wall = contact.id1 >= grain_count or contact.id2 >= grain_count
            effective = min(first, second) if at_wall else first * second / (first + second)
            contact.phys.kr = contact.phys.ks * effective * effective


# Steps between two settings of the rolling stiffness; one takes about as long as a step.
ROLLING_INTERVAL = 10

O.engines = (
    [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()], verletDist=job["verlet_distance"]),
        InteractionLoop(
            # `hertzian` gives a flat wall's stiffness; without it a facet counts as a sphere. With it moments would lock.
            [
                Ig2_Sphere_Sphere_ScGeom(),
                Ig2_Facet_Sphere_ScGeom(hertzian=not job["rolling"]),
                Ig2_Wall_Sphere_ScGeom(hertzian=True),
            ],
            [
                Ip2_FrictMat_FrictMat_MindlinPhys(
                    en=MatchMaker(matches=restitution, algo="val", val=0.5),
                    es=MatchMaker(matches=tangential, algo="val", val=0.5),
                    frictAngle=MatchMaker(matches=friction, algo="val", val=0.0),
                    **effects,
                )
            ],
            [
                Law2_ScGeom_MindlinPhys_Mindlin(
                    includeMoment=bool(job["rolling"]), includeAdhesion=bool(job["cohesion"])
                )
            ],
        ),
    ]
    + [engine for engine, _, _, _ in motions]
    + ([PyRunner(command="drive_walls()", iterPeriod=1)] if drives else [])
    + ([PyRunner(command="set_rolling_stiffness()", iterPeriod=ROLLING_INTERVAL)] if job["rolling"] else [])
    # YADE's hidden damping is 0.2 unless told otherwise.
    + [NewtonIntegrator(damping=0.0, gravity=Vector3(*job["gravity"]))]
    + ([PyRunner(command="hold_belts()", iterPeriod=1)] if belts else [])
)


def switch_motions(step):
    # What ends stands still before what begins at the same step moves on.
    for engine, _, last, ids in motions:
        if step == last:
            engine.dead = True
            for id in ids:
                O.bodies[id].state.vel = Vector3.Zero
                O.bodies[id].state.angVel = Vector3.Zero
    for engine, first, _, _ in motions:
        if step == first:
            engine.dead = False


def write_table(output, table):
    if sys.byteorder == "big":
        table.byteswap()
    table.tofile(output)


def write_driven_walls(output):
    write_table(output, array("d", [number for drive in drives for number in (drive["displacement"], drive["rate"])]))


def write_frame(output, step):
    grains = array("d")
    for id in range(grain_count):
        state = O.bodies[id].state
        grains.extend(state.pos)
        grains.extend(state.vel)
        grains.extend(state.angVel)
    contacts = array("d")
    count = 0
    for contact in O.interactions:
        if not contact.isReal:
            continue
        phys, geom = contact.phys, contact.geom
        # YADE's forces act on its second body; its normal points from the first to the second.
        force = phys.normalForce + phys.shearForce
        first, second, normal, on_first = contact.id1, contact.id2, geom.normal, -force
        if first >= grain_count:
            first, second, normal, on_first = second, first, -normal, force
        if force == Vector3.Zero:
            continue
        wall = wall_of.get(second)
        contacts.extend((first, 0.0 if wall is None else 1.0, second if wall is None else wall))
        contacts.extend(geom.contactPoint)
        contacts.extend(normal)
        contacts.extend(on_first)
        count += 1
    header = array("d", (step * job["time_step"], grain_count, count))
    for table in (header, grains, contacts):
        write_table(output, table)


def write_text(name, text):
    with open(name + ".part", "w") as file:
        file.write(text)
    os.replace(name + ".part", name)


def run():
    steps = job["steps"]
    frames = set(job["frames"])
    # Pieces end at frames, at the starts and stops of walls, and often enough to tell the progress.
    stops = frames | {0, steps} | set(range(0, steps, max(1, steps // 100)))
    for _, first, last, _ in motions:
        stops |= {first, last}
    stops = sorted(stops)
    parent = os.getppid()
    seconds = 0.0
    core_seconds = 0.0
    with open("frames.bin", "wb") as output, open("driven.bin", "wb") as driven:
        for here, there in zip(stops, stops[1:] + [None]):
            switch_motions(here)
            if here in frames:
                write_frame(output, here)
                write_driven_walls(driven)
            write_text("progress.txt", "%.6f" % (here / steps))
            if there is None:
                break
            start, core_start = time.perf_counter(), time.process_time()
            O.run(there - here, True)
            seconds += time.perf_counter() - start
            core_seconds += time.process_time() - core_start
            if os.getppid() != parent:
                raise SystemExit("the program that started this run is gone")
    write_text("result.json", json.dumps({"seconds": seconds, "core_seconds": core_seconds, "steps": O.iter}))


# Leave at once, whatever happened: YADE would keep its servers up, or open a shell after an error.
status = 1
try:
    run()
    status = 0
except BaseException:
    traceback.print_exc()
finally:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
