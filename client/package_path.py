# SPDX-License-Identifier: MIT
"""Lets the programs beside it import the package acus: that of the checkout, or that of the same installation, which
Python finds by itself only below /usr."""

import os
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
CHECKOUT = os.path.join(HERE, "python")
INSTALLED = os.path.normpath(os.path.join(HERE, "../../../lib/python3/dist-packages"))  # seen from share/acus/client

if os.path.isdir(os.path.join(CHECKOUT, "acus")):
    sys.path.insert(0, CHECKOUT)  # before an installed one
elif INSTALLED not in sys.path:
    sys.path.append(INSTALLED)
