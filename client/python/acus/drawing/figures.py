# SPDX-License-Identifier: MIT
"""Pictures in files."""

import io
import os

from PIL import Image

from .. import own_files
from ..errors import AcusError

DOTS_PER_INCH = 130  # of pixel pictures
COLOURS = 256  # of a .png: nobody sees a difference, and the file is a quarter as large


def save(figure, path):
    """Writes a Matplotlib figure; replaces pictures of Acus alone."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in own_files.PICTURES:
        raise AcusError(f"{path}: expected a name that ends with {', '.join(own_files.PICTURES)}")
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=DOTS_PER_INCH, format=ending[1:], metadata={own_files.PICTURES[ending][0]: own_files.WRITER})
    if ending != ".png":
        own_files.write(path, drawn.getvalue(), own_files.is_picture)
        return
    with Image.open(drawn) as image:
        small = image.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, 1, dither=Image.Dither.NONE)
    own_files.write_image(path, small)
