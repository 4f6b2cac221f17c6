# SPDX-License-Identifier: BSD-3-Clause
"""Default values that are also shown by commands; this module imports nothing."""

STARTS = 3000  # maximum number of searches for the branches of an island
