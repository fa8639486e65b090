# SPDX-License-Identifier: BSD-3-Clause
"""The one exception of files that are not what they should be."""


class FileError(ValueError):
    """A file is damaged, cut off, or of another kind or format. The sentence names the file and the place."""
