# SPDX-License-Identifier: GPL-3.0-or-later
"""The report as one HTML page: sections of plots and tables, each with a caption."""

import html
import os

import matplotlib.pyplot as plt

STYLE = """
body { font: 16px/1.5 sans-serif; color: #222; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
img { max-width: 100%; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 14px; }
th, td { padding: .2rem .7rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
th { border-bottom: 2px solid #222; vertical-align: bottom; }
tr.no { background: #fbe3d6; }
.caption { color: #555; max-width: 60rem; }
"""


def number(value):
    """A cell as people read it."""
    if isinstance(value, float):
        return f"{value:.0f}" if value == round(value) and abs(value) < 1e6 else f"{value:.3g}"
    return str(value)


class Section:
    def __init__(self, title, text=""):
        self.title = title
        self.parts = [f"<p>{text}</p>"] if text else []

    def plot(self, folder, figure, name, caption):
        figure.savefig(folder.file(name), dpi=110, bbox_inches="tight")
        plt.close(figure)
        text = html.escape(caption)
        self.parts.append(f'<p><img src="{name}" alt="{text}"></p><p class="caption">{text}</p>')

    def table(self, rows, caption, marked=lambda row: False):
        if not rows:
            return
        head = "".join(f"<th>{html.escape(key)}</th>" for key in rows[0])
        body = "".join(
            f'<tr{" class=no" if marked(row) else ""}>'
            + "".join(f"<td>{html.escape(number(value))}</td>" for value in row.values()) + "</tr>" for row in rows)
        self.parts.append(f'<table><tr>{head}</tr>{body}</table><p class="caption">{html.escape(caption)}</p>')

    def text(self, paragraph):
        self.parts.append(f"<p>{paragraph}</p>")


def write(folder, sections, title="Acus: errors and stability"):
    """Returns the page's path."""
    path = os.path.join(folder, "index.html")
    contents = "".join(f'<li><a href="#{i}">{html.escape(s.title)}</a></li>' for i, s in enumerate(sections))
    body = "".join(f'<h2 id="{i}">{html.escape(s.title)}</h2>' + "\n".join(s.parts) for i, s in enumerate(sections))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title>"
                   f"<style>{STYLE}</style><h1>{title}</h1><ul>{contents}</ul>{body}</html>\n")
    return path
