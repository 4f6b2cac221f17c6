# SPDX-License-Identifier: BSD-3-Clause
"""`python -m gelenk` is the `gelenk` command."""

from gelenk.cli import main

main()
