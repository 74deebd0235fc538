"""Grains that stay where they start, left as frames with a fault: faulty.py FOLDER SEED FAULT."""
import csv, os, sys, time

folder, seed, fault = sys.argv[1:4]
grains = [[float(row[name]) for name in ("id", "x", "y", "z", "radius")] for row in csv.DictReader(open(f"{folder}/grains.csv"))]
times = [float(row["time"]) for row in csv.DictReader(open(f"{folder}/frames.csv"))]


def leave(name, head, rows):
    with open(f"{folder}/{name}", "w") as out:
        csv.writer(out).writerows([head, *rows])


def frame(at, rows, name="out"):
    leave(f"{name}_{round(at * 1000)}.csv", ["id", "x", "y", "z", "radius"], rows)


if fault == "first-fails" and seed == "1":
    sys.exit(3)
if fault in ("slow", "first-fails"):
    time.sleep(60)
if fault == "reversed":
    grains = [[99 - row[0], *row[1:]] for row in grains]
if fault == "far":
    grains[5][1] += 1e6
if fault == "outside":
    grains[5][3] -= 0.5
if fault == "some-contacts":
    grains[1][1:4] = [grains[0][1] + grains[0][4] + grains[1][4], *grains[0][2:4]]
for place, at in enumerate(times):
    last = place == len(times) - 1
    rows = grains
    if fault == "lost-grain" and last:
        rows = grains[:-1]
    if fault == "renumbered" and last:
        rows = [[row[0] + 7, *row[1:]] for row in grains]
    if fault == "empty-frame" and last:
        rows = []
    if fault == "no-radii":
        leave(f"out_{round(at * 1000)}.csv", ["id", "x", "y", "z"], [row[:4] for row in rows])
        continue
    if fault == "just-early":
        # By 0.002 of an interval.
        own = [[at - 1e-4, *row] for row in rows]
        leave(f"out_{round(at * 1000)}.csv", ["time", "id", "x", "y", "z", "radius"], own)
        continue
    frame(at - 0.02 if fault == "early" and last else at, rows)
if fault == "late":
    frame(times[-1] + 0.02, grains)
if fault == "parts":
    frame(times[-1], grains[:50])
    frame(times[-1], grains[50:], "out_b")
if fault == "some-contacts":
    force = [[times[0], 0, 1, 0, 0, -1]]
    leave("contacts.csv", ["time", "first", "second", "fx", "fy", "fz"], force)
