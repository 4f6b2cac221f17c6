# SPDX-License-Identifier: BSD-3-Clause
"""Charts of what methods cost and where they fail: `gelenk chart`."""
