"""Counts the lines of the main logic of each integrator.

    python3 tests/reference/main_logic.py

Counted is what lies between the start of a sample and the film, in the function named below, as rustfmt lays it
out: without its signature, blank lines and comments. For gradients the shifts count too, for the Markov chain the
mutations, the paths that it starts with and its steps.
"""

import pathlib
import re

SOURCES = pathlib.Path(__file__).resolve().parents[2] / "integrators/src"
INTEGRATORS = [
    ("path", [("path.rs", "trace"), ("path.rs", "endings"), ("path.rs", "ended")]),
    ("bdpt", [("bidirectional.rs", "paths")]),
    ("tridir", [("tridirectional.rs", "sample")]),
    ("gdpt", [("path.rs", "endings"), ("path.rs", "ended"), ("gradient_domain.rs", "sample"),
              ("gradient_domain.rs", "gradient"), ("gradient_domain.rs", "shift"),
              ("shift.rs", "moved"), ("shift.rs", "copied"), ("shift.rs", "may_meet"), ("shift.rs", "is_rough"),
              ("shift.rs", "inverse"), ("shift.rs", "vertex"), ("shift.rs", "technique")]),
    ("mlt", [("mutations.rs", "propose"), ("mutations.rs", "follow"), ("mutations.rs", "is_smooth"),
             ("metropolis.rs", "contribution"), ("metropolis.rs", "covers"), ("metropolis.rs", "shares"),
             ("metropolis.rs", "seeds"), ("metropolis.rs", "chain"), ("metropolis.rs", "step")]),
    ("vpl", [("subpaths.rs", "shared_light_paths"), ("instant_radiosity.rs", "sample")]),
    ("ppm", [("photon_mapping.rs", "shoot"), ("photon_mapping.rs", "gather")]),
    ("vcm", [("subpaths.rs", "shared_light_paths"), ("vertex_merging.rs", "light"), ("vertex_merging.rs", "techniques"),
             ("vertex_merging.rs", "made"), ("vertex_merging.rs", "sample"), ("vertex_merging.rs", "ends")]),
    ("ptracer", [("light_tracer.rs", "sample")]),
]


def bodies(text, name):
    """The bodies of all functions with this name, as lists of lines."""
    lines = text.splitlines()
    for start, line in enumerate(lines):
        if not re.match(rf"\s*(pub )?fn {name}\b", line):
            continue
        indent = len(line) - len(line.lstrip())
        opening = next(i for i in range(start, len(lines)) if lines[i].endswith("{"))
        closing = next(i for i in range(opening, len(lines)) if lines[i] == " " * indent + "}")
        yield lines[opening + 1:closing]


def count(parts):
    total = 0
    for file, name in parts:
        for body in bodies((SOURCES / file).read_text(), name):
            code = [line.strip() for line in body]
            total += sum(1 for line in code if line and not line.startswith("//"))
    return total


if __name__ == "__main__":
    for name, parts in INTEGRATORS:
        print(f"{name:8} {count(parts):4}")
