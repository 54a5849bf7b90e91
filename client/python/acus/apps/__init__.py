# SPDX-License-Identifier: MIT
"""The programs of the package: `main()` of plot, picture and top is acus-plot, acus-picture and acus-top."""
