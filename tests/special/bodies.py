# SPDX-License-Identifier: BSD-3-Clause
"""An independent model: each body has six coordinates, each joint imposes constraints.

Twists are (w, v): angular velocity and velocity of the center of mass, both in world axes.

    G V = 0        constraints of the joints
    q' = H V       the joint velocities

Nothing is reduced. Only the normalized scene and the joint coordinates are taken from Gelenk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Array, Scene, rotation

import gelenk

# Singular values below this fraction of the largest count as zero: assembly finds a singular position, where
# the loops are flat, to the square root of round-off.
RANK_TOLERANCE = 1e-4
Poses = dict[str, tuple[Array, Array]]  # rotation, center of mass; the ground's is the identity


def from_quaternion(Q: Array) -> Array:
    """Q: x, y, z and the scalar part."""
    Q = Q / np.linalg.norm(Q)
    v, s = Q[:3], Q[3]
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    R: Array = np.eye(3) + 2 * s * K + 2 * K @ K
    return R


class UnknownError(Exception):
    """The scene contains an element that this model does not implement."""


@dataclass(frozen=True)
class Joint:
    """Frames relative to the centers of mass, in body axes."""

    name: str
    kind: str
    parent: str
    child: str
    R_P: Array
    in_parent: Array
    R_C: Array
    in_child: Array
    axes: list[Array]  # the first is fixed in F; a universal joint's second one in M
    across: Array  # columns perpendicular to the first axis, in F
    damping: list[float]
    stiffness: list[float]
    reference: list[float]


SPEEDS: dict[str, tuple[str, ...]] = {
    "revolute": ("w",),
    "prismatic": ("v",),
    "cylindrical": ("v", "w"),
    "universal": ("w_a", "w_b"),
    "planar": ("v_x", "v_y", "w"),
    "spherical": ("w[1]", "w[2]", "w[3]"),
    "free": ("v[1]", "v[2]", "v[3]", "w[1]", "w[2]", "w[3]"),
    "weld": (),
}
ACCELERATIONS: dict[str, tuple[str, ...]] = {
    "revolute": ("a",),
    "prismatic": ("a",),
    "cylindrical": ("a", "wd"),
    "universal": ("a_a", "a_b"),
    "planar": ("a_x", "a_y", "wd"),
    "spherical": ("z[1]", "z[2]", "z[3]"),
    "free": ("a[1]", "a[2]", "a[3]", "z[1]", "z[2]", "z[3]"),
    "weld": (),
}
COORDINATES: dict[str, tuple[str, ...]] = {
    "revolute": ("phi",),
    "prismatic": ("s",),
    "cylindrical": ("s", "phi"),
    "universal": ("phi_a", "phi_b"),
    "planar": ("s_x", "s_y", "phi"),
    "spherical": (),
    "free": (),
    "weld": (),
}


class Bodies:
    """The equations of a scene with all its bodies."""

    def __init__(self, source: Scene | gelenk.Scene) -> None:
        data = gelenk.load(source).to_dict()
        unknown = {c["type"] for c in data.get("constraints", {}).values()} - {"gear", "rack"}
        if unknown:
            raise UnknownError(", ".join(sorted(unknown)))
        self.data = data
        self.names = list(data["bodies"])
        self.place = {name: 6 * i for i, name in enumerate(self.names)}
        self.size = 6 * len(self.names)
        self.gravity = np.array(data.get("gravity", [0, 0, 0]), float)
        self.mass = {n: float(b["mass"]) for n, b in data["bodies"].items()}
        self.com = {n: np.array(b.get("com", [0, 0, 0]), float) for n, b in data["bodies"].items()}
        self.com["ground"] = np.zeros(3)
        self.moments = {}
        for n, b in data["bodies"].items():
            xx, yy, zz, xy, xz, yz = [*b.get("inertia", [0] * 6), 0, 0, 0][:6]
            self.moments[n] = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], float)
        self.joints = [self._joint(n, j) for n, j in data["joints"].items()]
        self.length = max(
            [1e-9, *(np.linalg.norm(p) for j in self.joints for p in (j.in_parent, j.in_child))]
        )

    def _frame(self, f: Mapping[str, Any]) -> tuple[str, Array, Array]:
        R = np.array(f.get("rotation", {"matrix": np.eye(3)})["matrix"], float)
        return f["body"], R, np.array(f.get("position", [0, 0, 0]), float) - self.com[f["body"]]

    def _joint(self, name: str, j: Mapping[str, Any]) -> Joint:
        if "stop" in j:
            raise UnknownError("stop")
        parent, R_P, p_P = self._frame(j["parent"])
        child, R_C, p_C = self._frame(j["child"])
        axes = [np.array(a, float) for a in j.get("axes", [j["axis"]] if "axis" in j else [])]
        if not axes:
            axes = [np.eye(3)[0], np.eye(3)[1]] if j["type"] == "universal" else [np.eye(3)[2]]
        axes = [a / np.linalg.norm(a) for a in axes]
        n = len(SPEEDS[j["type"]])
        if j["type"] == "planar" and axes[0][2] < 1:
            raise UnknownError("a planar joint whose normal is not z")

        def listed(key: str) -> list[float]:
            x = j.get(key, 0.0)
            return [float(v) for v in x] if isinstance(x, list) else [float(x)] * n

        return Joint(name, j["type"], parent, child, R_P, p_P, R_C, p_C, axes, _across(axes[0]),
                     listed("damping"), listed("stiffness"), listed("spring_reference"))  # fmt: skip

    # --- positions ---

    def poses(self, values: Mapping[str, float]) -> Poses:
        """Poses from the joint coordinates, along the first path that leads to each body."""
        out: Poses = {"ground": (np.eye(3), np.zeros(3))}
        left = list(self.joints)
        while left:
            j = next((j for j in left if (j.parent in out) or (j.child in out)), None)
            if j is None:
                raise UnknownError("a body that no joint connects")
            left.remove(j)
            R_FM, p_FM = self._displacement(j, values)
            if j.parent in out and j.child not in out:
                R, p = out[j.parent]
                R_M = R @ j.R_P @ R_FM
                R_C = R_M @ j.R_C.T
                out[j.child] = (R_C, p + R @ (j.in_parent + j.R_P @ p_FM) - R_C @ j.in_child)
            elif j.child in out and j.parent not in out:
                R, p = out[j.child]
                R_F = R @ j.R_C @ R_FM.T
                R_P = R_F @ j.R_P.T
                out[j.parent] = (R_P, p + R @ j.in_child - R_F @ p_FM - R_P @ j.in_parent)
        return out

    def _displacement(self, j: Joint, values: Mapping[str, float]) -> tuple[Array, Array]:
        q = [values[f"{j.name}.{c}"] for c in COORDINATES[j.kind]]
        R, p = np.eye(3), np.zeros(3)
        if j.kind == "revolute":
            R = rotation(j.axes[0], q[0])
        elif j.kind == "prismatic":
            p = q[0] * j.axes[0]
        elif j.kind == "cylindrical":
            R, p = rotation(j.axes[0], q[1]), q[0] * j.axes[0]
        elif j.kind == "universal":
            R = rotation(j.axes[0], q[0]) @ rotation(j.axes[1], q[1])
        elif j.kind == "planar":
            R, p = rotation([0, 0, 1], q[2]), np.array([q[0], q[1], 0])
        elif j.kind in ("spherical", "free"):
            R = from_quaternion(np.array([values[f"{j.name}.Q[{i}]"] for i in (1, 2, 3, 4)]))
            if j.kind == "free":
                p = np.array([values[f"{j.name}.r[{i}]"] for i in (1, 2, 3)])
        return R, p

    def moved(self, x: Poses, twist: Array) -> Poses:
        """A step along a constant twist."""
        out = dict(x)
        for name, at in self.place.items():
            w, v = twist[at : at + 3], twist[at + 3 : at + 6]
            R, p = x[name]
            angle = float(np.linalg.norm(w))
            out[name] = ((rotation(w, angle) @ R if angle > 0 else R), p + v)
        return out

    # --- constraints and joint velocities ---

    def _relative(self, x: Poses, j: Joint) -> tuple[Array, Array, Array, Array, Array]:
        """R_F, R_M, the vector from F to M, and the rows that give w and v of M relative to F (at M)."""
        R_P, p_P = x[j.parent]
        R_C, p_C = x[j.child]
        F, M = R_P @ j.in_parent, R_C @ j.in_child
        W, V = np.zeros((3, self.size)), np.zeros((3, self.size))
        for body, sign, arm in ((j.child, 1, M), (j.parent, -1, p_C + M - p_P)):
            if body == "ground":
                continue
            at = self.place[body]
            W[:, at : at + 3] += sign * np.eye(3)
            V[:, at : at + 3] -= sign * cross(arm)
            V[:, at + 3 : at + 6] += sign * np.eye(3)
        return R_P @ j.R_P, R_C @ j.R_C, p_C + M - p_P - F, W, V

    def rows(self, x: Poses) -> Array:
        """G, with lengths in units of the mechanism's size."""
        return np.vstack(
            [np.zeros((0, self.size)), *(self._of(x, j)[0] for j in self.joints), *self._gears(x)]
        )

    def closure_errors(self, x: Poses) -> Array:
        return np.concatenate([np.zeros(0), *(self._of(x, j)[1] for j in self.joints)])

    def _of(self, x: Poses, j: Joint) -> tuple[Array, Array]:
        R_F, R_M, offset, W, V = self._relative(x, j)
        V, offset = V / self.length, offset / self.length
        turn = _turned(R_F, R_M)
        if j.kind == "free":
            return np.zeros((0, self.size)), np.zeros(0)
        if j.kind == "spherical":
            return V, offset
        if j.kind == "universal":
            a, b = R_F @ j.axes[0], R_M @ j.axes[1]
            n = cross(a) @ b
            angle = np.array([j.axes[0] @ j.axes[1] - a @ b])
            return np.vstack([n @ W, V]), np.concatenate([angle, offset])
        if j.kind == "weld":
            return np.vstack([W, V]), np.concatenate([turn, offset])
        if j.kind == "prismatic":
            t = R_F @ j.across
            return np.vstack([W, t.T @ V]), np.concatenate([turn, t.T @ offset])
        a = j.axes[0]
        t = R_F @ j.across
        lean = t.T @ (cross(R_F @ a) @ (R_M @ a))
        if j.kind == "revolute":
            return np.vstack([t.T @ W, V]), np.concatenate([lean, offset])
        if j.kind == "cylindrical":
            return np.vstack([t.T @ W, t.T @ V]), np.concatenate([lean, t.T @ offset])
        n = R_F @ a  # planar
        return np.vstack([t.T @ W, n @ V]), np.concatenate([lean, [n @ offset]])

    def rates(self, x: Poses) -> tuple[list[str], Array]:
        """H, with the names of the velocities."""
        names, blocks = [], [np.zeros((0, self.size))]
        for j in self.joints:
            names += [f"{j.name}.{s}" for s in SPEEDS[j.kind]]
            blocks.append(self._rates_of(x, j))
        return names, np.vstack(blocks)

    def _rates_of(self, x: Poses, j: Joint) -> Array:
        R_F, R_M, _, W, V = self._relative(x, j)
        if j.kind == "spherical":
            return R_M.T @ W
        if j.kind == "free":
            return np.vstack([R_F.T @ V, R_M.T @ W])
        if j.kind == "planar":
            return np.vstack([(R_F.T @ V)[:2], (R_F.T @ W)[2]])
        if j.kind == "weld":
            return np.zeros((0, self.size))
        a = R_F @ j.axes[0]
        if j.kind == "universal":
            return np.asarray(np.linalg.pinv(np.column_stack([a, R_M @ j.axes[1]])) @ W)
        return np.vstack({"revolute": [a @ W], "prismatic": [a @ V], "cylindrical": [a @ V, a @ W]}[j.kind])

    def _gears(self, x: Poses) -> list[Array]:
        out = []
        known = {j.name: j for j in self.joints}
        for c in self.data.get("constraints", {}).values():
            if c["type"] == "rack":
                row = self._rates_of(x, known[c["rack"]]) - c["radius"] * self._rates_of(
                    x, known[c["pinion"]]
                )
                out.append(row / self.length)
                continue
            first, second = known[c["joint"]], known[c["with"]]
            row = self._rates_of(x, first) - c["ratio"] * self._rates_of(x, second)
            if "carrier" in c:
                raise UnknownError("carrier")
            out.append(row)
        return out

    # --- rank ---

    def rank(self, x: Poses) -> tuple[int, float]:
        """Rank of G, and the smallest nonzero singular value relative to the largest."""
        G = self.rows(x)
        if G.size == 0:
            return 0, 1.0
        s = np.linalg.svd(self._scaled(G), compute_uv=False)
        r = int((s > RANK_TOLERANCE * s[0]).sum())
        return r, float(s[r - 1] / s[0])

    def _scaled(self, G: Array) -> Array:
        out = G.copy()
        for at in self.place.values():
            out[:, at + 3 : at + 6] *= self.length
        return out

    def null_space(self, x: Poses, rank: int | None = None) -> Array:
        """Columns span the null space of G."""
        G = self._scaled(self.rows(x))
        if G.shape[0] == 0:
            N = np.eye(self.size)
        else:
            _, s, Vt = np.linalg.svd(G)
            N = Vt[int((s > RANK_TOLERANCE * s[0]).sum()) if rank is None else rank :].T.copy()
        for at in self.place.values():
            N[at + 3 : at + 6] *= self.length
        return N

    def closed(self, x: Poses) -> Poses | None:
        """The nearest position at which the loops are closed, by Levenberg-Marquardt steps."""
        for _ in range(40):
            blocks = [self._of(x, j) for j in self.joints]
            gap = np.concatenate([np.zeros(0), *(block[1] for block in blocks)])
            if np.abs(gap).max(initial=0) < 1e-13:
                return x
            G = self._scaled(np.vstack([block[0] for block in blocks]))
            A = G @ G.T
            dx = -G.T @ np.linalg.solve(A + 1e-10 * np.trace(A) / len(A) * np.eye(len(A)), gap)
            for at in self.place.values():
                dx[at + 3 : at + 6] *= self.length
            x = self.moved(x, dx)
        return x if np.abs(self.closure_errors(x)).max(initial=0) < 1e-11 else None

    def singular(self, x: Poses, seed: int = 0) -> bool:
        """Whether the rank is larger nearby, or some motions in the null space lead to no position."""
        rng = np.random.default_rng(seed)
        here = self.rank(x)[0]
        N = self.null_space(x)
        if N.shape[1] == 0:
            return False
        taken = []
        for _ in range(2 * N.shape[1] + 2):
            beside = self.beside(x, N @ rng.normal(size=N.shape[1]))
            if beside is not None:
                if self.rank(beside)[0] > here:
                    return True
                taken.append(np.linalg.lstsq(N, self.twist_between(x, beside), rcond=None)[0])
        if not taken:
            return True
        s = np.linalg.svd(np.array(taken), compute_uv=False)
        return len(s) < N.shape[1] or bool(s[-1] < 0.02 * s[0])

    def twist_between(self, x: Poses, y: Poses) -> Array:
        """The approximate twist that leads from x to y."""
        out = np.zeros(self.size)
        for name, at in self.place.items():
            out[at : at + 3] = _turned(x[name][0], y[name][0])
            out[at + 3 : at + 6] = y[name][1] - x[name][1]
        return out

    def beside(self, x: Poses, twist: Array) -> Poses | None:
        """A tenth of a radian along this motion, with loops closed there; None: it leads nowhere."""
        turn = max(np.abs(twist[at : at + 3]).max() for at in self.place.values())
        shift = max(np.abs(twist[at + 3 : at + 6]).max() for at in self.place.values())
        out = self.closed(self.moved(x, 0.1 * twist / max(turn, shift / self.length)))
        return None if out is None or self.distance(out, x) < 0.02 else out

    def distance(self, x: Poses, y: Poses) -> float:
        """The largest rotation [rad] or displacement of a body, in units of the mechanism's size."""
        turns = [float(np.abs(x[n][0] - y[n][0]).max()) for n in self.names]
        return max([*turns, *(float(np.abs(x[n][1] - y[n][1]).max()) / self.length for n in self.names)])

    def degrees_of_freedom(self, x: Poses, tries: int = 4) -> int:
        """The minimum number of free motions found here and at nearby positions."""
        rng = np.random.default_rng(0)
        best = self.rank(x)[0]
        for _ in range(tries):
            N = self.null_space(x)
            if N.shape[1] == 0:
                break
            beside = self.beside(x, N @ rng.normal(size=N.shape[1]))
            if beside is not None:
                best = max(best, self.rank(beside)[0])
        return self.size - best


def cross(p: Array) -> Array:
    return np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])


def _across(a: Array) -> Array:
    """Two columns perpendicular to a and each other."""
    x = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(a, x)])


def _turned(R_F: Array, R_M: Array) -> Array:
    """Rotation of M relative to F, for small rotations, in world axes."""
    K = R_M @ R_F.T
    return 0.5 * np.array([K[2, 1] - K[1, 2], K[0, 2] - K[2, 0], K[1, 0] - K[0, 1]])
