#!/usr/bin/env python3
"""The program `aether` and Mitsuba 3 on the same scene: seconds, error, and error^2 x time as ratios.

    peers.py SCENE.xml --reference REFERENCE.exr --mitsuba PYTHON [--variant scalar_rgb --variant llvm_ad_rgb]
             [--peer NAME=COMMAND ...]
             [--aether target/release/aether] [--integrator path] [--sampler NAME] [--spp 64] [--threads 2] [--runs 5]

PYTHON is an interpreter that can import mitsuba (3.9); llvm variants find LLVM by DRJIT_LIBLLVM_PATH. Size, filter
and depth are those of the scene file, for all. Renders alternate (A B C A B C ...), so that all see the same machine;
what is reported is the median over the runs. Seconds are those of rendering alone: of aether what it writes into its
image, of Mitsuba the time of `mi.render`, after one render that compiles. Beside them are processor seconds of all
threads, of aether those of the whole program, for machines that others use too. The error is relMSE, the mean of
(x - r)^2 / (r^2 + 0.01); of independent samples it falls as one over the time, so that relMSE x seconds does not depend
on how many there are. Of `--sampler ldsampler`, or where the scene asks for such samples, it falls faster.

Any other renderer takes part by a command, in which {spp}, {seed}, {threads} and {image}, the EXR file to be written,
are filled in, and {file:NAME} is a copy of that file beside it in which $spp, $seed and $threads are: it is the same
scene in the renderer's own format, with the same size, filter and depth. Its seconds are those of the command less those
of the same command with one sample, so that loading does not count. For example

    --peer 'pbrt-v4=pbrt --quiet --nthreads {threads} --seed {seed} --spp {spp} --outfile {image} box.pbrt'
    --peer 'pbrt-v3=pbrt-v3 --quiet --nthreads={threads} --outfile={image} {file:box-v3.pbrt}'
    --peer 'mitsuba-0.6=mitsuba -p {threads} -Dspp={spp} -o {image} box-0.6.xml'
    --peer 'luxcore=PYTHON tests/benches/luxcore.py box.cfg --spp {spp} --threads {threads} --seed {seed} -o {image}'

of which pbrt-v3 has the number of samples in its file.
"""

import argparse
import json
import pathlib
import re
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

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


def run(command):
    """Wall and processor seconds of a command, which is a list of words."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    except OSError as error:
        sys.exit(f"{command[0]}: {error}")
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{shlex.join(command)} has failed:\n{done.stdout[-2000:]}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def aether(options, judge, seed):
    """One render by aether; Mitsuba reads the image, so that both errors are computed alike."""
    with tempfile.TemporaryDirectory() as directory:
        out = str(pathlib.Path(directory) / "out.exr")
        command = [
            options.aether, "render", options.scene, "--integrator", options.integrator, "--spp", str(options.spp),
            "--threads", str(options.threads), "--seed", str(seed), "-o", out,
        ]
        command += ["--sampler", options.sampler] if options.sampler else []
        _, cpu = run(command)
        return judge.ask(image=out) | {"cpu": cpu}


class Program:
    """A renderer that is run by a command."""

    def __init__(self, command, options):
        self.words, self.threads = shlex.split(command), options.threads
        unknown = set(re.findall(r"\{([^}:]*)", command)) - {"spp", "seed", "threads", "image", "file"}
        if unknown:
            sys.exit(f"--peer: there is no {{{unknown.pop()}}}; there are spp, seed, threads, image and file:NAME")

    def words_for(self, values, files):
        """The words of the command; the names of the copies that it reads are added to `files`."""

        def copy(match):
            source = pathlib.Path(match[1])
            try:
                text = source.read_text()
            except OSError as error:
                sys.exit(f"--peer: {error}")
            for key, value in values.items():
                text = text.replace("$" + key, value)
            with tempfile.NamedTemporaryFile(
                "w", dir=source.parent, prefix="peer-", suffix=source.suffix, delete=False
            ) as file:
                file.write(text)
            files.append(file.name)
            return file.name

        for word in self.words:
            for key, value in values.items():
                word = word.replace("{" + key + "}", value)
            yield re.sub(r"\{file:([^}]*)\}", copy, word)

    def timed(self, spp, seed, image):
        values = {"spp": str(spp), "seed": str(seed), "threads": str(self.threads), "image": image}
        files = []
        try:
            return run(list(self.words_for(values, files)))
        finally:
            for file in files:
                pathlib.Path(file).unlink()

    def render(self, spp, seed, judge):
        """One render, and one with a single sample for what is no rendering."""
        with tempfile.TemporaryDirectory() as directory:
            image = str(pathlib.Path(directory) / "out.exr")
            least, _ = self.timed(1, seed, image)
            wall, cpu = self.timed(spp, seed, image)
            if not pathlib.Path(image).exists():
                sys.exit(f"{shlex.join(self.words)} has written no image {{image}}")
            # The samples less one that the difference stands for.
            seconds = (wall - least) * spp / max(spp - 1, 1)
            return judge.ask(image=image) | {"seconds": seconds, "cpu": cpu}


def named(text):
    """A name and a command, as NAME=COMMAND."""
    name, sign, command = text.partition("=")
    if not (name and sign and command.strip()):
        raise argparse.ArgumentTypeError(f"{text}: should be NAME=COMMAND")
    return name, command


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--reference", required=True)
    parser.add_argument("--mitsuba", required=True)
    parser.add_argument("--variant", action="append")
    parser.add_argument("--peer", action="append", type=named, default=[])
    parser.add_argument("--aether", default="target/release/aether")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--sampler", help="of aether, instead of the scene's")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    programs = {name: Program(command, options) for name, command in options.peer}
    variants = options.variant or ["scalar_rgb"]
    peers = {variant: Mitsuba(options, variant) for variant in variants}
    judge = peers[variants[0]]
    for peer in peers.values():
        peer.ask(render=True, spp=options.spp, seed=0)
    results = {name: [] for name in ["aether", *variants, *programs]}
    for seed in range(1, options.runs + 1):
        results["aether"].append(aether(options, judge, seed))
        for variant, peer in peers.items():
            results[variant].append(peer.ask(render=True, spp=options.spp, seed=seed))
        for name, program in programs.items():
            results[name].append(program.render(options.spp, seed, judge))
    middle = lambda name, key: statistics.median(result[key] for result in results[name])
    product = lambda name: middle(name, "seconds") * middle(name, "error")
    print(f"{'':14} {'seconds':>9} {'cpu':>9} {'relMSE':>10} {'relMSE x s':>11} {'ratio to aether':>16}")
    for name in results:
        seconds, cpu, error = (middle(name, key) for key in ("seconds", "cpu", "error"))
        print(f"{name:14} {seconds:9.3f} {cpu:9.3f} {error:10.3e} {product(name):11.3e} {product(name) / product('aether'):16.2f}")


if __name__ == "__main__":
    main()
