"""Draws docs/losses.svg: ρ, weight and influence of each loss, as the Python module computes them.

  PYTHONPATH=build/release/python python3 docs/site/losses.py docs/losses.svg
"""
import sys

import holdfast as hf

LOSSES = [("squared", "#777777", ""), ("huber:2", "#0072b2", ""), ("cauchy:2", "#e69f00", ""), ("geman_mcclure:2", "#009e73", ""),
          ("welsch:2", "#cc79a7", ""), ("tukey:4.685", "#d55e00", "6 3"), ("truncated_squares:3", "#000000", "2 3"),
          ("dcs:2", "#56b4e9", "")]
PANELS = [("ρ", 12.0), ("weight ρ'", 1.1), ("influence ρ' r", 4.0)]
REACH, STEPS, WIDTH, HEIGHT, GAP = 6.0, 240, 260, 200, 40


def cost(loss, r):
    """½ρ(r²), by a graph of one prior whose residual is r."""
    graph, values = hf.Graph(), hf.Values()
    values.insert("x0", hf.Scalar(r))
    graph.add(hf.Prior[hf.Scalar].from_sigmas(hf.Scalar(0.0), [1.0]), ["x0"], loss=loss)
    return graph.cost(values)


def curves(loss, r, h=1e-5):
    """ρ, ρ' and ρ' r at the residual r ≠ 0: the influence is the slope of the cost."""
    influence = (cost(loss, r + h) - cost(loss, r - h)) / (2 * h)
    return 2 * cost(loss, r), influence / r, influence


def svg():
    residuals = [-REACH + (i + 0.5) * 2 * REACH / STEPS for i in range(STEPS)]  # never 0
    drawn = {name: [curves(name, r) for r in residuals] for name, _, _ in LOSSES}
    parts = []
    for panel, (title, top) in enumerate(PANELS):
        left, bottom = -top if panel == 2 else 0.0, 30 + HEIGHT
        x = lambda r, panel=panel: 20 + panel * (WIDTH + GAP) + (r + REACH) / (2 * REACH) * WIDTH
        y = lambda v, low=left, top=top, bottom=bottom: bottom - (min(max(v, low), top) - low) / (top - low) * HEIGHT
        parts.append(f'<text x="{x(0):.1f}" y="20" text-anchor="middle">{title}, to {top:g}</text>')
        parts.append(f'<path d="M{x(-REACH):.1f} {y(0):.1f}H{x(REACH):.1f}M{x(0):.1f} {bottom}V30" stroke="#bbbbbb"/>')
        for r in range(-6, 7, 2):
            parts.append(f'<text x="{x(r):.1f}" y="{bottom + 14}" text-anchor="middle">{r}</text>')
        for name, colour, dash in LOSSES:
            points = " ".join(f"{x(r):.1f},{y(value[panel]):.1f}" for r, value in zip(residuals, drawn[name]))
            parts.append(f'<polyline points="{points}" stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"/>')
    for i, (name, colour, dash) in enumerate(LOSSES):
        left, line = 20 + i % 4 * 220, 275 + i // 4 * 20
        parts.append(f'<path d="M{left} {line}h26" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')
        parts.append(f'<text x="{left + 32}" y="{line + 4}">{name}</text>')
    body = "\n".join(parts).replace("<text", '<text stroke="none" fill="#222222"')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {3 * WIDTH + 2 * GAP + 40} 310" font-family="sans-serif" '
            f'font-size="12" fill="none">\n<title>ρ, weight and influence of each loss over the residual in sigmas</title>\n'
            f"{body}\n</svg>\n")


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(svg())
