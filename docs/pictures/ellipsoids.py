#!/usr/bin/env python3
"""Makes ellipsoids.png of docs/concepts.md: one arm, one joint circle, three views, three ellipses.

Usage: docs/pictures/ellipsoids.py (after tools/build; needs gnuplot)
"""

import json
import pathlib
import subprocess
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parent
MEASURE = FOLDER.parent.parent / "build" / "release" / "bin" / "vantage-measure"
VIEWS = [("from above", 10, 70), ("oblique", 60, 70), ("almost in the arm's plane", 87, 70), ("from above, arm stretched", 10, 4)]
CONFIG = """
robot: planar2
joints_deg: [20, {elbow}]
points: [{{position: [0, 0, 0]}}]
features: all_points
camera: {{units: pixels}}
camera_sphere: {{R: 1.2, theta_deg: {theta}, phi_deg: -90, target: [0.15, 0.45, 0]}}
translation_task: plane
"""


def measure(theta, elbow):
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(CONFIG.format(theta=theta, elbow=elbow))
        file.flush()
        return json.loads(subprocess.run([MEASURE, file.name, "--json"], check=True, capture_output=True).stdout)


def main():
    lines = ["set terminal pngcairo size 1500,370 font 'DejaVu Sans,10'", f"set output '{FOLDER}/ellipsoids.png'",
             "set multiplot layout 1,5 margins 0.03,0.99,0.17,0.94 spacing 0.03", "set size ratio -1", "set grid lc rgb '#dddddd'",
             "set parametric", "set trange [0:2*pi]", "set samples 200", "unset key",
             "set xrange [-1.5:1.5]", "set yrange [-1.5:1.5]", 'set title "all joint velocities\\nof speed 1 rad/s"',
             "set xlabel 'joint 1 [rad/s]'", "plot cos(t),sin(t) lw 2 lc rgb '#1f77b4'"]
    for title, theta, elbow in VIEWS:
        result = measure(theta, elbow)
        (a, b), (c, d) = result["ellipsoid"]["axes"][0], result["ellipsoid"]["axes"][1]
        sigma, w_c = result["singular_values_c"], result["w_c"]
        lines += ["set xtics 200", "set ytics 200", "set xrange [-450:450]", "set yrange [-450:450]", "set xlabel 'image u [px/s]'",
                  f'set title "{title}\\nw_c = {w_c:.0f}, sigma = {sigma[0]:.0f} and {sigma[1]:.0f} px/rad" noenhanced',
                  f"plot {a}*cos(t)+{c}*sin(t),{b}*cos(t)+{d}*sin(t) lw 2 lc rgb '#d62728'"]
    subprocess.run(["gnuplot"], input="\n".join(lines), text=True, check=True)


if __name__ == "__main__":
    main()
