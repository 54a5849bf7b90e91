# SPDX-License-Identifier: MIT
"""The programs of the package: `main()` of plot is acus-plot, likewise of picture, top, study and cloud."""
