# SPDX-License-Identifier: BSD-3-Clause
"""Many runs: designs, reductions, workers, resumption."""
