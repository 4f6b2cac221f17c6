# SPDX-License-Identifier: BSD-3-Clause
"""What standard jobs cost, in counts, which don't jitter as clocks do.

Evaluations of the equations of motion, and instructions of the processor. figures.json holds what was found
last; `make costs WHY="..."` writes it anew.
"""
