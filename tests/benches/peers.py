#!/usr/bin/env python3
"""The program `aether` and Mitsuba 3 on the same scene: seconds, error, and error^2 x time as ratios.

    peers.py SCENE.xml --reference REFERENCE.exr --mitsuba PYTHON [--variant scalar_rgb --variant llvm_ad_rgb]
             [--aether target/release/aether] [--integrator path] [--spp 64] [--threads 2] [--runs 5]

PYTHON is an interpreter that can import mitsuba (3.9); llvm variants find LLVM by DRJIT_LIBLLVM_PATH. Size, filter
and depth are those of the scene file, for all. Renders alternate (A B C A B C ...), so that all see the same machine;
what is reported is the median over the runs. Seconds are those of rendering alone: of aether what it writes into its
image, of Mitsuba the time of `mi.render`, after one render that compiles. Beside them are processor seconds of all
threads, of aether those of the whole program, for machines that others use too. The error is relMSE, the mean of
(x - r)^2 / (r^2 + 0.01); it falls as one over the time, so relMSE x seconds does not depend on the samples.
"""

import argparse
import json
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

# Runs inside PYTHON. Each line of its input asks for a render or for the error of an image.
WORKER = r"""
import json, os, sys, time
import mitsuba as mi
variant, threads, scene_file = sys.argv[1], int(sys.argv[2]), sys.argv[3]
mi.set_variant(variant)
import numpy as np
if variant.startswith("llvm"):
    import drjit as dr
    dr.set_thread_count(threads)
else:
    os.sched_setaffinity(0, set(sorted(os.sched_getaffinity(0))[:threads]))
mi.set_log_level(mi.LogLevel.Error)
scene = mi.load_file(scene_file)
def pixels(path):
    # Red, green and blue come first; aether writes their variances too, which makes other formats of it.
    return np.array(mi.Bitmap(path)).astype(np.float64)[..., :3]
for line in sys.stdin:
    job = json.loads(line)
    if "render" in job:
        start, used = time.perf_counter(), time.process_time()
        image = np.array(mi.render(scene, spp=job["spp"], seed=job["seed"]))[..., :3].astype(np.float64)
        answer = {"seconds": time.perf_counter() - start, "cpu": time.process_time() - used}
    else:
        bitmap = mi.Bitmap(job["image"])
        image = pixels(job["image"])
        metadata = bitmap.metadata()
        answer = {"seconds": float(metadata["seconds"]) if "seconds" in metadata else None}
    truth = pixels(job["reference"])
    answer["error"] = float(np.mean((image - truth) ** 2 / (truth ** 2 + 0.01)))
    print("answer " + json.dumps(answer), flush=True)
"""


class Mitsuba:
    """A process that renders with one variant."""

    def __init__(self, options, variant):
        command = [options.mitsuba, "-c", WORKER, variant, str(options.threads), options.scene]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.reference = options.reference

    def ask(self, **job):
        self.process.stdin.write(json.dumps({"reference": self.reference, **job}) + "\n")
        self.process.stdin.flush()
        for line in self.process.stdout:
            if "answer " in line:
                return json.loads(line[line.index("answer ") + len("answer "):])
        sys.exit("Mitsuba has ended: is the variant there, and does it load the scene?")


def aether(options, judge, seed):
    """One render by aether; Mitsuba reads the image, so that both errors are computed alike."""
    with tempfile.TemporaryDirectory() as directory:
        out = str(pathlib.Path(directory) / "out.exr")
        command = [
            options.aether, "render", options.scene, "--integrator", options.integrator, "--spp", str(options.spp),
            "--threads", str(options.threads), "--seed", str(seed), "-o", out,
        ]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return judge.ask(image=out) | {"cpu": cpu}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--reference", required=True)
    parser.add_argument("--mitsuba", required=True)
    parser.add_argument("--variant", action="append")
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    variants = options.variant or ["scalar_rgb"]
    peers = {variant: Mitsuba(options, variant) for variant in variants}
    judge = peers[variants[0]]
    for peer in peers.values():
        peer.ask(render=True, spp=options.spp, seed=0)
    results = {"aether": []} | {variant: [] for variant in variants}
    for seed in range(1, options.runs + 1):
        results["aether"].append(aether(options, judge, seed))
        for variant, peer in peers.items():
            results[variant].append(peer.ask(render=True, spp=options.spp, seed=seed))
    middle = lambda name, key: statistics.median(result[key] for result in results[name])
    product = lambda name: middle(name, "seconds") * middle(name, "error")
    print(f"{'':14} {'seconds':>9} {'cpu':>9} {'relMSE':>10} {'relMSE x s':>11} {'ratio to aether':>16}")
    for name in results:
        seconds, cpu, error = (middle(name, key) for key in ("seconds", "cpu", "error"))
        print(f"{name:14} {seconds:9.3f} {cpu:9.3f} {error:10.3e} {product(name):11.3e} {product(name) / product('aether'):16.2f}")


if __name__ == "__main__":
    main()
