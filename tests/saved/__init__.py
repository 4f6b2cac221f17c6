# SPDX-License-Identifier: BSD-3-Clause
"""What a run remembers: saved states, restored ones, steps that were discarded."""
