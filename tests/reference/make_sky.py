"""Writes tests/scenes/textures/sky.exr: a sky of 32 x 16 texels with a gradient, a bright sun of one texel
near the border of the picture, a dark ground and light at the pole below.

    python3 tests/reference/make_sky.py
"""

import numpy as np

from make_renders import SCENES, write_exr

WIDTH, HEIGHT = 32, 16


def main():
    """Writes the picture."""
    sky = np.zeros((HEIGHT, WIDTH, 3))
    for y in range(HEIGHT):
        for x in range(WIDTH):
            up = 1 - y / (HEIGHT - 1)
            around = x / WIDTH
            if up > 0.45:
                sky[y, x] = [0.2 + 0.3 * around, 0.4, 1.0 - 0.5 * up]
            else:
                sky[y, x] = [0.05 * (x % 3), 0.03, 0.0]
    sky[4, 31] = [120.0, 100.0, 60.0]
    sky[HEIGHT - 1] = [0.5, 0.0, 0.5]
    write_exr(SCENES / "textures/sky.exr", {c: sky[:, :, k] for k, c in enumerate("RGB")}, {})


if __name__ == "__main__":
    main()
