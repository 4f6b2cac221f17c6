# SPDX-License-Identifier: BSD-3-Clause
"""Run the `gelenk` command as `python -m gelenk`."""

from gelenk.cli import main

main()
