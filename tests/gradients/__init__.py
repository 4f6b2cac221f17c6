# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs, fits, designs."""
