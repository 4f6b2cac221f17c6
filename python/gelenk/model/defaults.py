# SPDX-License-Identifier: BSD-3-Clause
"""Defaults that commands tell, too; nothing has to be imported to read them."""

STARTS = 3000  # of searches for the branches of a part
