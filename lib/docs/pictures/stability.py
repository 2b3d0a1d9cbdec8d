#!/usr/bin/env python3
"""Draw the maps of lib/docs/stability.md: the figures of `enamel design --stability`, below each other.

Usage: stability.py build/release/apps/enamel/enamel. Needs chromium.
"""
import os
import re
import subprocess
import sys
import tempfile

PICTURES = os.path.dirname(os.path.abspath(__file__))
DEVICES = os.path.join(PICTURES, "../../../data/devices")


def figures(enamel, device, folder):
    """Return the figures of a device's page, as a browser draws them."""
    page = os.path.join(folder, device + ".html")
    subprocess.run([enamel, "design", "--device", os.path.join(DEVICES, device + ".toml"), "--stability", page],
                   check=True, stdout=subprocess.DEVNULL)
    browser = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=8000", "--dump-dom"]
    dom = subprocess.run(browser + ["file://" + page], check=True, capture_output=True, text=True).stdout
    return re.findall(r"<svg.*?</svg>", dom, re.S)


def joined(parts, label):
    """Return one picture without the texts for screen readers; hundredths of a pixel suffice."""
    body, width, height = "", 0, 0
    for part in parts:
        w, h = map(int, re.search(r'viewBox="0 0 (\d+) (\d+)"', part).groups())
        part = re.sub(r' (aria-[a-z]+|role|class)="[^"]*"', "", part)
        part = re.sub(r"<svg [^>]*>", f'<svg y="{height}" width="{w}" height="{h}" viewBox="0 0 {w} {h}">', part, count=1)
        part = re.sub(r"(\d+\.\d{2})\d+", r"\1", re.sub(r"<g>\s*</g>", "", part))
        body += re.sub(r"><(g|path|text|rect)", r">\n<\1", part) + "\n"
        width, height = max(width, w), height + h + 10
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height - 10}" role="img" '
            f'aria-label="{label}" font-family="sans-serif">\n'
            f'<rect width="{width}" height="{height - 10}" fill="white"/>\n{body}</svg>\n')


with tempfile.TemporaryDirectory() as temporary:
    for name in ["cartesian-3", "cartesian-6", "stylus", "delta", "tau-nominal", "tau-detailed"]:
        text = joined(figures(sys.argv[1], name, temporary), "Stability of position control on " + name)
        with open(os.path.join(PICTURES, "stability-" + name + ".svg"), "w") as file:
            file.write(text)
