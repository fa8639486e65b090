# SPDX-License-Identifier: BSD-3-Clause
"""The exception for invalid files."""


class FileError(ValueError):
    """A file is damaged, truncated, or of another type or format. The sentence names the file and the position."""
