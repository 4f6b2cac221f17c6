# SPDX-License-Identifier: BSD-3-Clause
"""What adaptive integrators make of the tolerance that is asked of them: docs/accuracy.md."""
