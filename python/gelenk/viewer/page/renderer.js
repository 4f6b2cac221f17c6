// SPDX-License-Identifier: BSD-3-Clause
// The WebGL canvas: creates the renderer and keeps its size and quality.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // Draws that follow each other faster than this, in milliseconds, belong to a motion.
  const motionGap = 250;
  const largestRatio = 3;

  // Whether the processor draws in place of a graphics card, as in virtual machines.
  function drawsInSoftware() {
    const context = document.createElement("canvas").getContext("webgl");
    if (!context) return false;
    const details = context.getExtension("WEBGL_debug_renderer_info");
    const name = String(context.getParameter(details ? details.UNMASKED_RENDERER_WEBGL : context.RENDERER));
    const release = context.getExtension("WEBGL_lose_context");
    if (release) release.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  }

  // Without a graphics card multisampling halves the frame rate. There we draw plainly while
  // something moves, and at twice the resolution as soon as nothing moves any more.
  Gelenk.Picture = class {
    // `redraw` asks for another draw, which improves the picture when the motion is over.
    constructor(canvas, redraw) {
      this.redraw = redraw;
      this.software = drawsInSoftware();
      this.lastDraw = -Infinity;
      this.width = this.height = 1;
      // Our own context, because three.js reports a missing one as an error on the console.
      const options = { antialias: !this.software, alpha: false, powerPreference: "high-performance" };
      const context = canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);
      this.renderer = context ? new THREE.WebGLRenderer({ canvas, context }) : null;
    }

    get available() {
      return Boolean(this.renderer);
    }

    resize(width, height) {
      this.width = width;
      this.height = height;
      this.size = "";
    }

    setBackground(color) {
      if (this.renderer) this.renderer.setClearColor(color);
    }

    setSize(quick) {
      const ratio = (window.devicePixelRatio || 1) * (this.software && !quick ? 2 : 1);
      const size = `${this.width} ${this.height} ${ratio}`;
      if (size === this.size) return;
      this.size = size;
      this.renderer.setPixelRatio(Math.min(largestRatio, ratio));
      this.renderer.setSize(this.width, this.height, false);
    }

    draw(scene, camera, playing) {
      if (!this.renderer) return;
      const now = performance.now();
      const quick = playing || now - this.lastDraw < motionGap;
      this.setSize(quick);
      this.renderer.render(scene, camera);
      this.lastDraw = performance.now();
      clearTimeout(this.timer);
      if (this.software && quick && !playing) this.timer = setTimeout(() => this.redraw(), motionGap + 50);
    }
  };
})();
