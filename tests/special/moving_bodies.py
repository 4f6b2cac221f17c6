# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations from the Newton-Euler equations of all bodies with joint constraints.

    M V' = f - G' lambda,   G V' = -dG/dt V,   q'' = H V' + dH/dt V

Rates of G and H are finite differences along the motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from mechanisms import Array

from .bodies import ACCELERATIONS, COORDINATES, RANK_TOLERANCE, SPEEDS, Bodies, Poses, UnknownError, cross


class MovingBodies(Bodies):
    """The equations of motion of a scene with all its bodies."""

    def twist(self, x: Poses, values: Mapping[str, float]) -> Array:
        """Twists of the bodies for these joint velocities."""
        names, H = self.rates(x)
        G = self.rows(x)
        wanted = np.concatenate([[values[n] for n in names], np.zeros(len(G))])
        V: Array = np.linalg.lstsq(np.vstack([H, G]), wanted, rcond=None)[0]
        return V

    def accelerations(self, x: Poses, V: Array, values: Mapping[str, float]) -> dict[str, float]:
        """Accelerations of the joint coordinates, without inputs."""
        names, H = self.rates(x)
        G = self.rows(x)
        h = 1e-4 / max(1.0, float(np.abs(V).max(initial=0)))
        after, before = self.moved(x, h * V), self.moved(x, -h * V)
        Gdot_V = (self.rows(after) - self.rows(before)) @ V / (2 * h)
        Hdot_V = (self.rates(after)[1] - self.rates(before)[1]) @ V / (2 * h)
        M, f = self._newton(x, V)
        f = f + self._loads(x, V, values, H)
        M = M + self._rotors(H, names)
        f = f - self._rotors_turning(H, names) @ Hdot_V
        a0 = -np.linalg.lstsq(G, Gdot_V, rcond=RANK_TOLERANCE)[0] if len(G) else np.zeros(self.size)
        N = self.null_space(x)
        y = np.linalg.lstsq(N.T @ M @ N, N.T @ (f - M @ a0), rcond=1e-13)[0]
        found = H @ (a0 + N @ y) + Hdot_V
        accelerations = [f"{j.name}.{a}" for j in self.joints for a in ACCELERATIONS[j.kind]]
        return dict(zip(accelerations, found.tolist(), strict=True))

    def _newton(self, x: Poses, V: Array) -> tuple[Array, Array]:
        M, f = np.zeros((self.size, self.size)), np.zeros(self.size)
        for name, at in self.place.items():
            R = x[name][0]
            moments = R @ self.moments[name] @ R.T
            w = V[at : at + 3]
            M[at : at + 3, at : at + 3] = moments
            M[at + 3 : at + 6, at + 3 : at + 6] = self.mass[name] * np.eye(3)
            f[at : at + 3] = -np.cross(w, moments @ w)
            f[at + 3 : at + 6] = self.mass[name] * self.gravity
        return M, f

    def _loads(self, x: Poses, V: Array, values: Mapping[str, float], H: Array) -> Array:
        f = np.zeros(self.size)
        speeds = H @ V
        k = 0
        for j in self.joints:
            coordinates = COORDINATES[j.kind]
            for i in range(len(SPEEDS[j.kind])):
                tau = -j.damping[i] * speeds[k]
                if j.stiffness[i] and coordinates:
                    tau -= j.stiffness[i] * (values[f"{j.name}.{coordinates[i]}"] - j.reference[i])
                f += tau * H[k]
                k += 1
        for load in self.data.get("forces", {}).values():
            f += self._force(x, V, load)
        return f

    def _force(self, x: Poses, V: Array, load: Mapping[str, Any]) -> Array:
        if load["type"] == "wrench":
            R, _ = x[load["body"]]
            arm = R @ (np.array(load.get("position", [0, 0, 0]), float) - self.com[load["body"]])
            force, torque = (np.array(load.get(k, [0, 0, 0]), float) for k in ("force", "torque"))
            if load.get("frame", "world") == "body":
                raise UnknownError("wrench in a body's frame")
            f = np.zeros(self.size)
            at = self.place[load["body"]]
            f[at : at + 3], f[at + 3 : at + 6] = torque + np.cross(arm, force), force
            return f
        if load["type"] != "spring_damper":
            raise UnknownError(load["type"])
        ends = self._ends(x, load)
        offset, rows = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
        length = float(np.linalg.norm(offset))
        n = offset / length
        pull = (
            load.get("stiffness", 0) * (length - load.get("length", 0))
            + load.get("damping", 0) * n @ rows @ V
        )
        return np.asarray(-pull * (n @ rows))

    def has_zero_length_spring(self, x: Poses) -> bool:
        """Whether the ends of a spring coincide."""
        springs = [f for f in self.data.get("forces", {}).values() if f["type"] == "spring_damper"]
        offsets = [np.subtract(*(place for place, _ in self._ends(x, f))) for f in springs]
        return any(float(np.linalg.norm(offset)) < 1e-9 * self.length for offset in offsets)

    def _ends(self, x: Poses, load: Mapping[str, Any]) -> list[tuple[Array, Array]]:
        """End points of a spring, and the matrices that give their velocities."""
        ends = []
        for key in ("from", "to"):
            body = load[key]["body"]
            R, p = x[body]
            arm = R @ (np.array(load[key].get("position", [0, 0, 0]), float) - self.com[body])
            rows = np.zeros((3, self.size))
            if body != "ground":
                at = self.place[body]
                rows[:, at : at + 3], rows[:, at + 3 : at + 6] = -cross(arm), np.eye(3)
            ends.append((p + arm, rows))
        return ends

    def _rotors_turning(self, H: Array, names: list[str]) -> Array:
        """H' J of the motors' rotors, with gear ratios."""
        out = np.zeros((self.size, len(names)))
        for motor in self.data.get("motors", {}).values():
            J = motor.get("gear_ratio", 1.0) ** 2 * motor.get("rotor_inertia", 0.0)
            k = next(i for i, n in enumerate(names) if n.startswith(f"{motor['joint']}."))
            out[:, k] += J * H[k]
        return out

    def _rotors(self, H: Array, names: list[str]) -> Array:
        out: Array = self._rotors_turning(H, names) @ H
        return out
