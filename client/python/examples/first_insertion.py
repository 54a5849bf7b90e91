# SPDX-License-Identifier: MIT
"""A first insertion: push a needle 50 mm into a block, and draw the force against the depth.

Cells begin with `# %%`, as editors and Jupyter read them. The picture goes to first_insertion.png.
"""

# %% A server of our own. In lockstep a tick runs when we ask for it, so nothing depends on how fast this program is.
import acus

server = acus.Server(acus.find_scene("insertion_pullback"), lockstep=True)
client = server.client()
needle = client.needles[0]
print(f"scene '{client.hello.scene}', {client.hello.rate:g} Hz; needle of {1e3 * needle.length:g} mm")

# %% One pose a tick, at 50 mm/s. The first pose acquires the needle.
SPEED = 0.05  # m/s
states = []
for tick in range(1, round(0.06 / SPEED / client.time_step)):
    client.pose(needle.name, needle.base_position + tick * SPEED * client.time_step * needle.axis)
    states.append(client.step(1))

# %% All that was answered, as arrays.
run = acus.Run.of_states(states)
track = run[needle.name]
for event in run.events:
    print(f"{event.time:.3f} s: {event.kind} of '{event.region}' at {event.force:.2f} N")
print(f"at {1e3 * track.depth[-1]:.1f} mm the tissue resists with {track.axial_resistance[-1]:.2f} N")

# %% The picture.
try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from acus.drawing import figures
except ImportError:
    print("no picture: Matplotlib or Pillow is not installed")
else:
    plt.plot(1e3 * track.depth, track.axial_resistance)
    plt.xlabel("needle inside the tissue (mm)")
    plt.ylabel("axial resistance (N)")
    figures.save(plt.gcf(), "first_insertion.png")  # replaces no picture of anybody else's

# %% The end.
client.close()
server.end()
