# SPDX-License-Identifier: BSD-3-Clause
"""A second opinion: every body by six coordinates, every joint by what it forbids. Nothing is reduced here.

Twists are (w, v): angular velocity and velocity of the centre of mass, both along the world's axes.

    G V = 0                       what joints forbid
    M V' + f = loads - G' lambda  Newton, Euler
    q' = H V                      the joints' speeds

Gelenk lends its normal form of a scene and the joints' coordinates at the point, from which poses follow.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Array, Scene, rotation

import gelenk

# Singular values below this part of the largest one count as none: assembly meets a singular position, where the
# loops are flat, to the root of rounding.
SAME_ROW = 1e-5
Poses = dict[str, tuple[Array, Array]]  # rotation, centre of mass; the ground's is the identity


def from_quaternion(Q: Array) -> Array:
    """Q: x, y, z and the scalar part."""
    Q = Q / np.linalg.norm(Q)
    v, s = Q[:3], Q[3]
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    R: Array = np.eye(3) + 2 * s * K + 2 * K @ K
    return R


class Unknown(Exception):
    """The scene has something of which this model knows nothing."""


@dataclass(frozen=True)
class Joint:
    """Frames in the bodies' own, with centres of mass as origins."""

    name: str
    kind: str
    parent: str
    child: str
    R_P: Array
    p_P: Array
    R_C: Array
    p_C: Array
    axes: list[Array]  # the first fixed in F; a universal joint's second one in M
    across: Array  # columns at right angles to the first one, in F
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
    """The equations of a scene by all its bodies."""

    def __init__(self, source: Scene | gelenk.Scene) -> None:
        data = gelenk.load(source).to_dict()
        unknown = {c["type"] for c in data.get("constraints", {}).values()} - {"gear", "rack"}
        if unknown:
            raise Unknown(", ".join(sorted(unknown)))
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
        self.length = max([1e-9, *(np.linalg.norm(p) for j in self.joints for p in (j.p_P, j.p_C))])

    def _frame(self, f: Mapping[str, Any]) -> tuple[str, Array, Array]:
        R = np.array(f.get("rotation", {"matrix": np.eye(3)})["matrix"], float)
        return f["body"], R, np.array(f.get("position", [0, 0, 0]), float) - self.com[f["body"]]

    def _joint(self, name: str, j: Mapping[str, Any]) -> Joint:
        if "stop" in j:
            raise Unknown("stop")
        parent, R_P, p_P = self._frame(j["parent"])
        child, R_C, p_C = self._frame(j["child"])
        axes = [np.array(a, float) for a in j.get("axes", [j["axis"]] if "axis" in j else [])]
        if not axes:
            axes = [np.eye(3)[0], np.eye(3)[1]] if j["type"] == "universal" else [np.eye(3)[2]]
        axes = [a / np.linalg.norm(a) for a in axes]
        n = len(SPEEDS[j["type"]])
        if j["type"] == "planar" and axes[0][2] < 1:
            raise Unknown("a planar joint whose normal is not z")

        def listed(key: str) -> list[float]:
            x = j.get(key, 0.0)
            return [float(v) for v in x] if isinstance(x, list) else [float(x)] * n

        return Joint(name, j["type"], parent, child, R_P, p_P, R_C, p_C, axes, _across(axes[0]),
                     listed("damping"), listed("stiffness"), listed("spring_reference"))  # fmt: skip

    # --- where everything is ---

    def poses(self, values: Mapping[str, float]) -> Poses:
        """From the joints' coordinates, along the first way that leads to each body."""
        out: Poses = {"ground": (np.eye(3), np.zeros(3))}
        left = list(self.joints)
        while left:
            j = next((j for j in left if (j.parent in out) or (j.child in out)), None)
            if j is None:
                raise Unknown("a body that no joint connects")
            left.remove(j)
            R_FM, p_FM = self._displacement(j, values)
            if j.parent in out and j.child not in out:
                R, p = out[j.parent]
                R_M = R @ j.R_P @ R_FM
                R_C = R_M @ j.R_C.T
                out[j.child] = (R_C, p + R @ (j.p_P + j.R_P @ p_FM) - R_C @ j.p_C)
            elif j.child in out and j.parent not in out:
                R, p = out[j.child]
                R_F = R @ j.R_C @ R_FM.T
                R_P = R_F @ j.R_P.T
                out[j.parent] = (R_P, p + R @ j.p_C - R_F @ p_FM - R_P @ j.p_P)
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

    # --- what joints forbid and what they let through ---

    def _relative(self, x: Poses, j: Joint) -> tuple[Array, Array, Array, Array, Array]:
        """R_F, R_M, the way from F to M, and the rows that give w and v of M against F (at M)."""
        R_P, p_P = x[j.parent]
        R_C, p_C = x[j.child]
        F, M = R_P @ j.p_P, R_C @ j.p_C
        W, V = np.zeros((3, self.size)), np.zeros((3, self.size))
        for body, sign, arm in ((j.child, 1, M), (j.parent, -1, p_C + M - p_P)):
            if body == "ground":
                continue
            at = self.place[body]
            W[:, at : at + 3] += sign * np.eye(3)
            V[:, at : at + 3] -= sign * _cross(arm)
            V[:, at + 3 : at + 6] += sign * np.eye(3)
        return R_P @ j.R_P, R_C @ j.R_C, p_C + M - p_P - F, W, V

    def rows(self, x: Poses) -> Array:
        """G, lengths in units of the mechanism's size."""
        return np.vstack([np.zeros((0, self.size)), *(self._of(x, j)[0] for j in self.joints), *self._gears(x)])

    def gaps(self, x: Poses) -> Array:
        """What G V is the rate of."""
        return np.concatenate([np.zeros(0), *(self._of(x, j)[1] for j in self.joints)])

    def _of(self, x: Poses, j: Joint) -> tuple[Array, Array]:
        R_F, R_M, way, W, V = self._relative(x, j)
        V, way = V / self.length, way / self.length
        turn = _turned(R_F, R_M)
        if j.kind == "free":
            return np.zeros((0, self.size)), np.zeros(0)
        if j.kind == "spherical":
            return V, way
        if j.kind == "universal":
            a, b = R_F @ j.axes[0], R_M @ j.axes[1]
            n = _cross(a) @ b
            angle = np.array([j.axes[0] @ j.axes[1] - a @ b])
            return np.vstack([n @ W, V]), np.concatenate([angle, way])
        if j.kind == "weld":
            return np.vstack([W, V]), np.concatenate([turn, way])
        if j.kind == "prismatic":
            t = R_F @ j.across
            return np.vstack([W, t.T @ V]), np.concatenate([turn, t.T @ way])
        a = j.axes[0]
        t = R_F @ j.across
        lean = t.T @ (_cross(R_F @ a) @ (R_M @ a))
        if j.kind == "revolute":
            return np.vstack([t.T @ W, V]), np.concatenate([lean, way])
        if j.kind == "cylindrical":
            return np.vstack([t.T @ W, t.T @ V]), np.concatenate([lean, t.T @ way])
        n = R_F @ a  # planar
        return np.vstack([t.T @ W, n @ V]), np.concatenate([lean, [n @ way]])

    def rates(self, x: Poses) -> tuple[list[str], Array]:
        """H, with the speeds' names."""
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
                row = self._rates_of(x, known[c["rack"]]) - c["radius"] * self._rates_of(x, known[c["pinion"]])
                out.append(row / self.length)
                continue
            first, second = known[c["joint"]], known[c["with"]]
            row = self._rates_of(x, first) - c["ratio"] * self._rates_of(x, second)
            if "carrier" in c:
                raise Unknown("carrier")
            out.append(row)
        return out

    # --- rank ---

    def rank(self, x: Poses) -> tuple[int, float]:
        """Of G; and the least singular value that counts, as a part of the largest."""
        G = self.rows(x)
        if G.size == 0:
            return 0, 1.0
        s = np.linalg.svd(self._scaled(G), compute_uv=False)
        r = int((s > SAME_ROW * s[0]).sum())
        return r, float(s[r - 1] / s[0])

    def _scaled(self, G: Array) -> Array:
        out = G.copy()
        for at in self.place.values():
            out[:, at + 3 : at + 6] *= self.length
        return out

    def free(self, x: Poses, rank: int | None = None) -> Array:
        """Columns span the twists that G lets through."""
        G = self._scaled(self.rows(x))
        if G.shape[0] == 0:
            N = np.eye(self.size)
        else:
            _, s, Vt = np.linalg.svd(G)
            N = Vt[int((s > SAME_ROW * s[0]).sum()) if rank is None else rank :].T.copy()
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
        return x if np.abs(self.gaps(x)).max(initial=0) < 1e-11 else None

    def generic_rank(self, x: Poses, seed: int = 0, tries: int = 4) -> int:
        """The largest rank found here and at positions near by."""
        rng = np.random.default_rng(seed)
        best = self.rank(x)[0]
        for _ in range(tries):
            N = self.free(x)
            if N.shape[1] == 0:
                break
            twist = N @ rng.normal(size=N.shape[1])
            turn = max(np.abs(twist[at : at + 3]).max() for at in self.place.values())
            shift = max(np.abs(twist[at + 3 : at + 6]).max() for at in self.place.values())
            beside = self.closed(self.moved(x, 0.15 * twist / max(turn, shift / self.length)))
            if beside is not None:
                best = max(best, self.rank(beside)[0])
        return best

    # --- motion ---

    def twist(self, x: Poses, values: Mapping[str, float]) -> Array:
        """Of the bodies at these joints' speeds."""
        names, H = self.rates(x)
        G = self.rows(x)
        wanted = np.concatenate([[values[n] for n in names], np.zeros(len(G))])
        V: Array = np.linalg.lstsq(np.vstack([H, G]), wanted, rcond=None)[0]
        return V

    def accelerations(self, x: Poses, V: Array, values: Mapping[str, float]) -> dict[str, float]:
        """Of the joints' coordinates, without inputs."""
        names, H = self.rates(x)
        G = self.rows(x)
        h = 1e-4 / max(1.0, float(np.abs(V).max(initial=0)))
        after, before = self.moved(x, h * V), self.moved(x, -h * V)
        Gdot_V = (self.rows(after) - self.rows(before)) @ V / (2 * h)
        Hdot_V = (self.rates(after)[1] - self.rates(before)[1]) @ V / (2 * h)
        M, f = self._newton(x, V)
        f = f + self._loads(x, V, values, names, H)
        M = M + self._rotors(H, names)
        f = f - self._rotors_turning(H, names) @ Hdot_V
        a0 = -np.linalg.lstsq(G, Gdot_V, rcond=SAME_ROW)[0] if len(G) else np.zeros(self.size)
        N = self.free(x)
        y = np.linalg.lstsq(N.T @ M @ N, N.T @ (f - M @ a0), rcond=1e-13)[0]
        found = H @ (a0 + N @ y) + Hdot_V
        told = [f"{j.name}.{a}" for j in self.joints for a in ACCELERATIONS[j.kind]]
        return dict(zip(told, found.tolist(), strict=True))

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

    def _loads(self, x: Poses, V: Array, values: Mapping[str, float], names: list[str], H: Array) -> Array:
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
                raise Unknown("wrench in a body's frame")
            f = np.zeros(self.size)
            at = self.place[load["body"]]
            f[at : at + 3], f[at + 3 : at + 6] = torque + np.cross(arm, force), force
            return f
        ends = self._ends(x, load)
        way, rows = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
        length = float(np.linalg.norm(way))
        n = way / length
        pull = load.get("stiffness", 0) * (length - load.get("length", 0)) + load.get("damping", 0) * n @ rows @ V
        return np.asarray(-pull * (n @ rows))

    def slack(self, x: Poses) -> bool:
        """Whether the ends of a spring are at one point."""
        springs = [f for f in self.data.get("forces", {}).values() if f["type"] == "spring_damper"]
        ways = [np.subtract(*(place for place, _ in self._ends(x, f))) for f in springs]
        return any(float(np.linalg.norm(way)) < 1e-9 * self.length for way in ways)

    def _ends(self, x: Poses, load: Mapping[str, Any]) -> list[tuple[Array, Array]]:
        """Of a spring: where they are, and what gives their velocities."""
        ends = []
        for key in ("from", "to"):
            body = load[key]["body"]
            R, p = x[body]
            arm = R @ (np.array(load[key].get("position", [0, 0, 0]), float) - self.com[body])
            rows = np.zeros((3, self.size))
            if body != "ground":
                at = self.place[body]
                rows[:, at : at + 3], rows[:, at + 3 : at + 6] = -_cross(arm), np.eye(3)
            ends.append((p + arm, rows))
        return ends

    def _rotors_turning(self, H: Array, names: list[str]) -> Array:
        """H' J of the motors' rotors, geared."""
        out = np.zeros((self.size, len(names)))
        for motor in self.data.get("motors", {}).values():
            J = motor.get("gear_ratio", 1.0) ** 2 * motor.get("rotor_inertia", 0.0)
            k = next(i for i, n in enumerate(names) if n.startswith(f"{motor['joint']}."))
            out[:, k] += J * H[k]
        return out

    def _rotors(self, H: Array, names: list[str]) -> Array:
        out: Array = self._rotors_turning(H, names) @ H
        return out


def _cross(p: Array) -> Array:
    return np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])


def _across(a: Array) -> Array:
    """Two columns at right angles to a and each other."""
    x = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(a, x)])


def _turned(R_F: Array, R_M: Array) -> Array:
    """How far M is turned against F, for small turns, along the world's axes."""
    K = R_M @ R_F.T
    return 0.5 * np.array([K[2, 1] - K[1, 2], K[0, 2] - K[2, 0], K[1, 0] - K[0, 1]])
