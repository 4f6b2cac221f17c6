# SPDX-License-Identifier: BSD-3-Clause
"""Measurements of contacts for docs/nonsmooth-measurements.md: bodies with known motions, cost of piles."""
