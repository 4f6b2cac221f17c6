# SPDX-License-Identifier: BSD-3-Clause
"""Figures of Andrews' squeezing mechanism at 0.03 s, published with the Test Set for IVP Solvers: PSIDE on a
Cray at 1e-14.
"""

END = {
    "beta": 15.81077119629904,
    "Theta": -15.75637105984298,
    "gamma": 0.04082224013073101,
    "Phi": -0.5347301163226948,
    "delta": 0.5244099658805303,
    "Omega": 0.5347301163226948,
    "epsilon": 1.048080741042263,
}
END_RATES = {
    "beta": 1139.920302151208,
    "Theta": -1424.379294994111,
    "gamma": 11.03291221937134,
    "Phi": 19.29337464421385,
    "delta": 0.5735699284790808,
    "Omega": -19.29337464421385,
    "epsilon": 0.3231791658026955,
}
