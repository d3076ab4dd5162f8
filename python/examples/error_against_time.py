"""Plots the estimated error of a picture against time, for several integrators.

Each ``# %%`` begins a cell of a notebook. From a shell:

    python python/examples/error_against_time.py --time 20 -o error.png
"""

# %% Import the renderer, and choose a scene.
import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import caustica

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "glass-ball.txt"


# %% Record the estimated error after each pass that estimates it.
def error_curve(scene, integrator, seconds, size):
    """Returns times, errors and error intervals of a render of `seconds` seconds."""
    curve = []

    def record(progress):
        if progress.error is not None:
            curve.append((progress.seconds, progress.error))

    # A pass with few photons is short, so the curve begins early.
    scene.render(integrator, time=seconds, size=size, callback=record)
    times = [seconds for seconds, _ in curve]
    return times, [error.error for _, error in curve], [error.interval for _, error in curve]


# %% Plot one curve for each integrator, with its interval.
def plot(curves, path):
    """Plots `curves`, a dict of the results of `error_curve`, to the file `path`."""
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for name, (times, errors, intervals) in curves.items():
        (line,) = axes.plot(times, errors, label=name)
        low, high = zip(*intervals) if intervals else ((), ())
        axes.fill_between(times, low, high, color=line.get_color(), alpha=0.2, linewidth=0)
    axes.set(xscale="log", yscale="log", xlabel="time [s]", ylabel="estimated relative error")
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)


# %% Render, and plot.
def main():
    """Reads the command line, renders and plots."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=SCENE, type=Path)
    parser.add_argument("--integrators", nargs="+", default=["hybrid", "sppm"], choices=caustica.INTEGRATORS)
    parser.add_argument("--time", type=float, default=20, help="seconds of each render")
    parser.add_argument("--size", default="240x180", type=lambda text: tuple(map(int, text.split("x"))))
    parser.add_argument("-o", "--output", default="error.png", type=Path)
    arguments = parser.parse_args()
    scene = caustica.load_file(arguments.scene)
    curves = {
        name: error_curve(scene, name, arguments.time, arguments.size) for name in arguments.integrators
    }
    plot(curves, arguments.output)
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
