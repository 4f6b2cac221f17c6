# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of mechanisms without a browser: what the page shows, drawn in software."""
