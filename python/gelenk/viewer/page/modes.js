// SPDX-License-Identifier: BSD-3-Clause
// The choice of a mode shape and of its amplitude.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const element = (id) => document.getElementById(id);

  Gelenk.ModeBar = class {
    // `changed` is called when the motion has become another one.
    constructor(recording, changed) {
      Object.assign(this, { recording, changed });
      this.mode = recording.modes[0];
      if (!this.mode) return;
      element("modes").hidden = false;
      const select = element("mode");
      recording.modes.forEach((mode, i) => select.append(new Option(`Mode ${mode.number}: ${mode.label}`, String(i))));
      select.addEventListener("change", () => this.choose(Number(select.value)));
      element("amplitude").addEventListener("input", () => this.choose(Number(select.value)));
      element("mode-text").textContent = this.mode.text;
    }

    choose(number) {
      const { recording } = this;
      this.mode = recording.modes[number];
      element("mode").value = String(number);
      element("mode-text").textContent = this.mode.text;
      recording.time = this.mode.time;
      recording.poses = this.scaled(element("amplitude").valueAsNumber / 100);
      this.changed();
    }

    // Displacements of the bodies from the operating point are multiplied by `factor`. For the first and
    // largest of them loops are closed exactly, for others to first order.
    scaled(factor) {
      if (factor === 1) return this.mode.poses;
      const rest = this.recording.second.poses;
      const poses = new Float32Array(this.mode.poses.length);
      const [a, b, p, q] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Quaternion(), new THREE.Quaternion()];
      for (let i = 0; i < poses.length; i += 7) {
        a.fromArray(rest, i).lerp(b.fromArray(this.mode.poses, i), factor).toArray(poses, i);
        p.fromArray(rest, i + 3).slerp(q.fromArray(this.mode.poses, i + 3), factor).normalize().toArray(poses, i + 3);
      }
      return poses;
    }
  };
})();
