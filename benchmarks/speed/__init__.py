# SPDX-License-Identifier: BSD-3-Clause
"""What Gelenk's kernels and runs cost beside other engines: `make bench`."""
