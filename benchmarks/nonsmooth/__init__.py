# SPDX-License-Identifier: BSD-3-Clause
"""Dry friction and hard limits, measured: docs/nonsmooth-measurements.md."""
