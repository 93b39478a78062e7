#!/usr/bin/env python3
"""How long compiling takes: a table of a clean build of the workspace, of a user's crate with one sampler (clean, and
after its sampler has changed), of expanding that sampler, and of how many lines it becomes.

    compile_times.py [--release] [--skip-workspace] [--json]

Builds go to a directory of their own, which is removed; crates are downloaded before the clock starts. Processor
seconds count all processes, and say more than seconds where others use the machine too. The macros are compiled as
cargo does by default in the user's crate; the workspace has settings of its own.
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
MANIFEST = """[package]
name = "one-sampler"
version = "0.1.0"
edition = "2024"
[workspace]
[dependencies]
aether-core = {{ path = "{}" }}
"""
SAMPLER = """use aether_core::prelude::*;
/// Directions about +z, distributed as cos(theta) / pi.
#[sampler]
pub fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}
"""


def timed(command, folder, target):
    """Seconds and processor seconds of a command."""
    environment = os.environ | {"CARGO_TARGET_DIR": str(target), "CARGO_INCREMENTAL": "0"}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"seconds": seconds, "cpu": cpu}, done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--release", action="store_true")
    parser.add_argument("--skip-workspace", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    build = ["cargo", "build"] + (["--release"] if options.release else [])
    rows = {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if not options.skip_workspace:
            subprocess.run(["cargo", "fetch"], cwd=ROOT, check=True, capture_output=True)
            rows["workspace, clean"], _ = timed([*build, "--workspace"], ROOT, folder / "workspace")
        user = folder / "user"
        (user / "src").mkdir(parents=True)
        (user / "Cargo.toml").write_text(MANIFEST.format(ROOT / "aether-core"))
        source = user / "src" / "lib.rs"
        sampler, nothing = "//! One sampler.\n" + SAMPLER, "//! None.\n"
        source.write_text(sampler)
        subprocess.run(["cargo", "fetch"], cwd=user, check=True, capture_output=True)
        rows["one sampler, clean"], _ = timed(build, user, folder / "target")
        source.write_text(nothing)
        empty, _ = timed(build, user, folder / "target")
        source.write_text(sampler)
        again, _ = timed(build, user, folder / "target")
        rows["one sampler, again"] = again
        rows["the sampler itself"] = {key: again[key] - empty[key] for key in again}
        # The same compiler, asked for what the macro makes: an option of the nightly one.
        os.environ["RUSTC_BOOTSTRAP"] = "1"
        _, done = timed(["cargo", "rustc", "--lib", "--", "-Zunpretty=expanded"], user, folder / "target")
        lines = len(done.stdout.splitlines())
    if options.json:
        print(json.dumps({"rows": rows, "expanded_lines": lines}, indent=1))
        return
    print(f"{'':22} {'seconds':>9} {'cpu':>9}")
    for name, row in rows.items():
        print(f"{name:22} {row['seconds']:9.2f} {row['cpu']:9.2f}")
    print(f"{'lines after expansion':22} {lines:>9}")


if __name__ == "__main__":
    main()
