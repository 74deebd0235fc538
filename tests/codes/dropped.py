"""Grains that are dropped one after the other and stay where they first touch something."""
import csv, json, math, sys

folder = sys.argv[1]
scene = json.load(open(f"{folder}/scene.json"))
grains = [{name: float(row[name]) for name in ("id", "x", "y", "z", "radius")} for row in csv.DictReader(open(f"{folder}/grains.csv"))]
times = [float(row["time"]) for row in csv.DictReader(open(f"{folder}/frames.csv"))]
floor, placed = scene["domain"]["min"][2], []
for grain in sorted(grains, key=lambda grain: grain["z"]):
    grain["z"] = floor + grain["radius"]
    for below in placed:
        reach = grain["radius"] + below["radius"]
        apart = (grain["x"] - below["x"]) ** 2 + (grain["y"] - below["y"]) ** 2
        if apart < reach**2:
            grain["z"] = max(grain["z"], below["z"] + math.sqrt(reach**2 - apart))
    placed.append(grain)
with open(f"{folder}/out.csv", "w") as out:
    table = csv.writer(out)
    table.writerow(["time", "id", "x", "y", "z", "radius"])
    table.writerows([time, *grain.values()] for time in times for grain in grains)
