"""What stepping from Python costs over stepping from Rust, in pairs of runs one after the other.

    cargo build --release -p makadam-validation && pip install .
    python python/benchmarks/stepping_cost.py target/release/makadam --scene drum-50k --steps 60 --pairs 5

The command `makadam run` tells the wall time of its steps, frames and files left out, each of which Python takes by one call of `step`.
Both begin with the same flowing state, and the states that they end with are compared bit for bit.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import tempfile
import time

import makadam


def rust(command: str, scene: str, steps: int, threads: int) -> tuple[float, str]:
    """Wall time of the steps by the command, s, and the hash of the state."""
    with tempfile.TemporaryDirectory() as folder:
        said = subprocess.run(
            [command, "run", scene, "--steps", str(steps), "--threads", str(threads), "--json", "--quiet", "--output", folder],
            check=True,
            capture_output=True,
            text=True,
        )
    run = json.loads(said.stdout)
    return run["wall_seconds"], run["state_hash"]


def python(scene: str, steps: int, threads: int, each: int, views: bool) -> tuple[float, str]:
    """The same from Python, by calls of `each` steps, with views of the grains held or not."""
    simulation = makadam.Simulation(scene, threads=threads)
    held = (simulation.positions, simulation.velocities, simulation.ids) if views else ()
    begun = time.perf_counter()
    for _ in range(0, steps, each):
        simulation.step(each)
    seconds = time.perf_counter() - begun
    del held
    return seconds, simulation.state_hash


def main() -> None:
    """Prints the median ratio of pairs, and their range."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", help="the makadam command, of the same sources")
    parser.add_argument("--scene", default="drum-50k")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--each", type=int, default=1, help="steps of one call from Python")
    parser.add_argument("--views", action="store_true", help="hold views of positions, velocities and ids meanwhile")
    arguments = parser.parse_args()
    ratios = []
    for pair in range(arguments.pairs):
        measured = {}
        # The order changes from pair to pair, so that what drifts falls on both.
        for who in ("rust", "python") if pair % 2 == 0 else ("python", "rust"):
            if who == "rust":
                measured[who] = rust(arguments.command, arguments.scene, arguments.steps, arguments.threads)
            else:
                measured[who] = python(arguments.scene, arguments.steps, arguments.threads, arguments.each, arguments.views)
        if measured["rust"][1] != measured["python"][1]:
            raise SystemExit(f"the states differ: {measured}")
        ratios.append(measured["python"][0] / measured["rust"][0])
        print(f"rust {measured['rust'][0]:.3f} s, python {measured['python'][0]:.3f} s, ratio {ratios[-1]:.4f}")
    print(f"median {100 * (statistics.median(ratios) - 1):+.2f}%, from {100 * (min(ratios) - 1):+.2f}% to {100 * (max(ratios) - 1):+.2f}%")


if __name__ == "__main__":
    main()
