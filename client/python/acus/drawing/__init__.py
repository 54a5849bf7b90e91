# SPDX-License-Identifier: MIT
"""What the programs and the package draw with. Needs matplotlib and pillow."""
