# SPDX-License-Identifier: MIT
"""Lets the programs beside it import the package acus: that of the checkout, or that of the same installation, which
Python finds by itself only below /usr and /usr/local."""

import os
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
for folder in ("python", "../../../lib/python3/dist-packages"):  # of the checkout; from share/acus/client
    if os.path.isdir(os.path.join(HERE, folder, "acus")):
        sys.path.insert(0, os.path.normpath(os.path.join(HERE, folder)))
        break
