# SPDX-License-Identifier: BSD-3-Clause
"""Plants for learning."""
