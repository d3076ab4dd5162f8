"""Denoises a picture by Open Image Denoise, with the albedo and normal of its surfaces.

Needs the packages pyoidn and, for .png, matplotlib. Each ``# %%`` begins a cell of a notebook.
From a shell:

    python python/examples/denoise.py scenes/goblet.txt -o goblet.png --passes 8
"""

# %% Import the renderer and the denoiser.
import argparse
from pathlib import Path

import numpy as np
import pyoidn

import caustica

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "glass-ball.txt"


# %% Denoise a result of `render(aovs=True)`.
def denoise(result, keep_caustics=False):
    """Returns the denoised picture of `result`: float32, height × width × 3, linear radiance.

    `keep_caustics` leaves caustic light as it is; `result` then needs its light groups. The error
    estimate of `result` does not hold for the picture that is returned.
    """
    layers = result.layers
    color, caustic = layers["image"], 0
    if keep_caustics:
        color, caustic = layers["direct"] + layers["indirect"], layers["caustic"]
    # A filter with negative lobes can leave negative radiance, which OIDN does not read.
    color = np.maximum(color, 0)
    return pyoidn.denoise(color, layers["albedo"], layers["normal"], hdr=True) + caustic


# %% Write linear radiance as .npy, or what a screen shows as .png.
def write(image, path):
    """Writes `image` to the file `path`: .npy or .png."""
    if path.suffix == ".npy":
        np.save(path, image)
        return
    import matplotlib.image

    linear = np.clip(image, 0, 1)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    matplotlib.image.imsave(path, shown)


# %% Render, denoise and write.
def main():
    """Reads the command line, renders and denoises."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=SCENE, type=Path)
    parser.add_argument("--passes", type=int, default=8)
    parser.add_argument("--size", default="320x240", type=lambda text: tuple(map(int, text.split("x"))))
    parser.add_argument("--keep-caustics", action="store_true", help="leave caustic light as it is")
    parser.add_argument("-o", "--output", default="denoised.png", type=Path)
    arguments = parser.parse_args()
    scene = caustica.load_file(arguments.scene)
    options = {"passes": arguments.passes, "size": arguments.size, "light_groups": arguments.keep_caustics}
    result = scene.render(aovs=True, **options)
    write(denoise(result, arguments.keep_caustics), arguments.output)
    print(f"wrote {arguments.output}; before denoising: {result.error}")


if __name__ == "__main__":
    main()
