# SPDX-License-Identifier: MIT
"""The page that acus-top shows: what a Watch knows, as lines of text."""

import math

from acus.messages import FLAG_NAMES, flag_names

MS = 1e3  # per s
MM = 1e3  # per m

COLUMNS = ["needle", "held", "phase", "depth mm", "axial N", "force N", "torque N m", "tip N", "fresh", "age ms", "lost",
           "reordered", "flags"]


def readable(text):
    """Names come from the server: they must not move the cursor."""
    return "".join(character if character.isprintable() else "?" for character in str(text))


def length(vector):
    return math.sqrt(sum(component * component for component in vector))


def flags_text(flags):
    unknown = flags >> len(FLAG_NAMES) << len(FLAG_NAMES)
    return ", ".join(flag_names(flags) + ([hex(unknown)] if unknown else [])) or "none"


def title(hello, silence, silent_after, refused):
    if hello is None:
        return f"acus-top: {refused or 'no server has answered yet'}"
    state = [name for name in ("lockstep", "paused") if hello[name]]
    if silence is not None and silence > silent_after:
        state.append(f"NO WORD FOR {silence:.0f} s")
    return f"acus-server {readable(hello['server'])}, scene '{readable(hello['scene'])}'" + "".join(
        ", " + word for word in state)


def distribution(name, stats, key, meaning):
    p50, p99, largest = (MS * stats[f"{key}_{which}"] for which in ("p50", "p99", "max"))
    return f"{name:<10}{p50:9.3f}{p99:9.3f}{largest:9.3f}   {meaning}"


def rate_line(hello, stats):
    held = stats["ticks"] / stats["period"] if stats["period"] > 0 else 0
    line = f"rate      {held:.1f} of {hello['rate']:g} Hz"
    if hello["lockstep"]:
        return line
    late = 1000 * stats["late"] / stats["ticks"] if stats["ticks"] else 0
    return f"{line}; late {late:.1f} of 1,000 ticks; {stats['overruns']} deadlines skipped since the start"


def stats_lines(hello, stats):
    listeners = ", ".join(map(readable, stats["subscribed"])) or "nobody"
    return [
        f"at        epoch {stats['epoch']}, tick {stats['tick']}, {stats['time']:.3f} s",
        rate_line(hello, stats),
        "",
        f"{'ms':<10}{'p50':>9}{'p99':>9}{'max':>9}",
        distribution("began", stats, "wake", "after a tick was due"),
        distribution("ended", stats, "end", "after a tick was due"),
        distribution("computed", stats, "tick", "for a tick"),
        "",
        f"work      at most {stats['rows']} rows, {stats['newton_iterations']} iterations, {stats['sweeps']} sweeps; "
        f"residual {stats['residual']:.1e} N, imbalance {stats['imbalance']:.1e} of {stats['largest_force']:.3g} N",
        f"flags     {flags_text(stats['flags'])}",
        f"clients   listen to {listeners}; {stats['rejected']} messages rejected, {stats['dropped']} states dropped",
        f"recording {recording_text(hello, stats)}",
    ]


def recording_text(hello, stats):
    if stats["recording"] == "failed":
        return "FAILED: it ended by itself, as the server's log says"
    return f"{stats['recording']} {readable(hello.get('recording', ''))}".strip()


def needle_row(needle, held, force):
    name = readable(needle["name"])
    if force is None:
        return [name, held] + ["-"] * (len(COLUMNS) - 2)
    phase = readable(force["phase"]) + (" stale" if force["stale"] else "")
    return [name, held, phase, f"{MM * force['depth']:.1f}", f"{round(-force['base_force_in_base'][0], 3) + 0.0:.3f}",
            f"{length(force['base_force']):.3f}", f"{length(force['base_torque']):.4f}",
            f"{length(force['tip_force']):.3f}", f"{100 * force['fresh']:.0f} %", f"{MS * force['age']:.1f}",
            str(force["lost"]), str(force["reordered"]), flags_text(force["flags"])]


def table(rows):
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ["  ".join(cell.ljust(width) if column in (0, 1, 2, len(widths) - 1) else cell.rjust(width)
                      for column, (cell, width) in enumerate(zip(row, widths))).rstrip() for row in rows]


def body_lines(hello, forces):
    held = set(hello["held"])
    rows = [COLUMNS] + [needle_row(needle, "yes" if needle["name"] in held else "no", forces.get(needle["name"]))
                        for needle in hello["needles"]]
    guides = [f"guide '{readable(guide['name'])}' of '{readable(guide['needle'])}': "
              + ("held" if guide["name"] in held else "not held") for guide in hello["guides"]]
    return table(rows) + guides


def page(watch, silent_after):
    """The lines."""
    lines = [title(watch.hello, watch.silence(), silent_after, watch.refused())]
    if watch.hello is None:
        return lines
    if watch.stats is not None:
        lines += stats_lines(watch.hello, watch.stats)
    return lines + [""] + body_lines(watch.hello, watch.forces)
