# SPDX-License-Identifier: BSD-3-Clause
"""Measurements of contacts for docs/contact.md: single bodies with known motions, and the cost of piles."""
