"""Solves one friction-contact problem with Siconos: reads a JSON job from standard input, writes a JSON answer.

The job holds W in compressed columns (rows, p, i, x), q, mu, a tolerance and the most iterations; the answer holds the impulses
r, the iterations, the error by Siconos' own measure, whether it is within the tolerance, and the seconds of the solve.
"""

import json
import sys
import time

import numpy as np
import siconos.numerics as numerics

job = json.load(sys.stdin)
size = job["rows"]
matrix = np.zeros((size, size))
for column in range(size):
    for entry in range(job["p"][column], job["p"][column + 1]):
        matrix[job["i"][entry], column] += job["x"][entry]
problem = numerics.FrictionContactProblem(3, size // 3, matrix, np.array(job["q"]), np.array(job["mu"]))
options = numerics.SolverOptions(numerics.SICONOS_FRICTION_3D_NSGS)
options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = job["most_iterations"]
options.dparam[numerics.SICONOS_DPARAM_TOL] = job["tolerance"]
impulses, velocities = np.zeros(size), np.zeros(size)
start = time.perf_counter()
info = numerics.fc3d_driver(problem, impulses, velocities, options)
seconds = time.perf_counter() - start
print(
    json.dumps(
        {
            "impulses": impulses.tolist(),
            "iterations": int(options.iparam[numerics.SICONOS_IPARAM_ITER_DONE]),
            "error": float(options.dparam[numerics.SICONOS_DPARAM_RESIDU]),
            "converged": info == 0,
            "seconds": seconds,
        }
    )
)
