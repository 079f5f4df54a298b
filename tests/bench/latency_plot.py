"""Draws percentiles as an SVG: a panel for each way to receive, with and without security."""

import math
from html import escape

PERCENTILES = (("median_us", "50"), ("p90_us", "90"), ("p99_us", "99"), ("p999_us", "99.9"), ("p9999_us", "99.99"))
COLORS = {"ddssec": "#0b6e4f", "Cyclone": "#c1440e", "UDP": "#555555"}
WIDTH, HEIGHT, LEFT, TOP, GAP = 360, 240, 60, 50, 60


def panels(figures):
    """[(title, [(variant, figures)])]; the floor is in each."""
    out = {}
    for variant, found in figures.items():
        if variant.make != "UDP":
            title = f"{variant.mode}, {'secured' if variant.secured else 'not secured'}"
            out.setdefault(title, []).append((variant, found))
    floor = [(variant, found) for variant, found in figures.items() if variant.make == "UDP"]
    return [(title, floor + lines) for title, lines in out.items()] or [("UDP", floor)]


def scale(figures):
    """The least and the greatest power of ten that hold all values."""
    values = [max(found[key], 1) for found in figures.values() for key, _ in PERCENTILES]
    return math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)) + 1e-9)


def panel(title, lines, low, high):
    def y(value):
        return HEIGHT * (1 - (math.log10(max(value, 1)) - low) / max(high - low, 1))

    xs = [WIDTH * i / (len(PERCENTILES) - 1) for i in range(len(PERCENTILES))]
    out = [f'<text x="0" y="-8" font-weight="bold">{escape(title)}</text>']
    for power in range(low, high + 1):
        at = y(10 ** power)
        out.append(f'<path d="M0 {at:.1f}H{WIDTH}" stroke="#ddd"/>'
                   f'<text x="-6" y="{at + 4:.1f}" text-anchor="end">{10 ** power}</text>')
    for x, (_, name) in zip(xs, PERCENTILES):
        out.append(f'<text x="{x:.1f}" y="{HEIGHT + 16}" text-anchor="middle">{name}</text>')
    for i, (variant, found) in enumerate(lines):
        dash = "" if variant.reliable or variant.make == "UDP" else ' stroke-dasharray="5 3"'
        points = " ".join(f"{x:.1f},{y(found[key]):.1f}" for x, (key, _) in zip(xs, PERCENTILES))
        name = "UDP" if variant.make == "UDP" else f"{variant.make}, {'reliable' if variant.reliable else 'best effort'}"
        out.append(f'<polyline points="{points}" fill="none" stroke="{COLORS[variant.make]}" stroke-width="1.5"{dash}/>'
                   f'<path d="M8 {12 + 14 * i}h22" stroke="{COLORS[variant.make]}" stroke-width="1.5"{dash}/>'
                   f'<text x="34" y="{16 + 14 * i}">{escape(name)}</text>')
    return out


def draw(title, figures):
    """The text of the SVG."""
    low, high = scale(figures)
    out = []
    shown = panels(figures)
    for i, (name, lines) in enumerate(shown):
        x, y = LEFT + i % 2 * (WIDTH + LEFT + 20), TOP + 20 + i // 2 * (HEIGHT + GAP)
        out += [f'<g transform="translate({x},{y})">', *panel(name, lines, low, high), "</g>"]
    width, height = 2 * (WIDTH + LEFT + 20), TOP + 20 + (len(shown) + 1) // 2 * (HEIGHT + GAP)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="11"><rect width="100%" height="100%" fill="white"/>'
            f'<text x="10" y="20">{escape(title)}</text><text x="10" y="36">percentile across, microseconds up</text>'
            + "\n".join(out) + "</svg>\n")
