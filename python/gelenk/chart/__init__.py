# SPDX-License-Identifier: BSD-3-Clause
"""Work-precision diagrams and stability maps of the solver methods: `gelenk chart`."""
