# SPDX-License-Identifier: BSD-3-Clause
"""Error of adaptive integrators relative to the tolerance: docs/accuracy.md."""
