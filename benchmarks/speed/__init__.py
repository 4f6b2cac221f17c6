# SPDX-License-Identifier: BSD-3-Clause
"""Processor time of Gelenk's kernels and runs compared with other engines: `make bench`."""
