// SPDX-License-Identifier: BSD-3-Clause
// One line chart of a signal over time on a two-dimensional canvas.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const font = "11px system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', sans-serif";

  // As many digits as distinguish neighboring ticks, without the noise of binary fractions.
  function tickText(value, step) {
    if (Math.abs(value) < 1e-9 * step) return "0";
    const size = Math.abs(value);
    const last = Math.floor(Math.log10(step) + 1e-9);
    const digits = Math.max(0, Math.min(6, Math.floor(Math.log10(size) + 1e-9) - last));
    const text = size >= 1e5 || step < 1e-4 ? value.toExponential(digits) : value.toFixed(Math.max(0, -last));
    return text.replace("e+", "e").replace(/-/g, "\u2212");
  }

  function ticks(low, high, count) {
    const step = Gelenk.roundStep(high - low, count);
    const list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
      list.push({ value: k * step, text: tickText(k * step, step) });
    }
    return list;
  }

  Gelenk.valueText = function (value) {
    if (!Number.isFinite(value)) return "\u2013";
    const size = Math.abs(value);
    const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(3) : value.toPrecision(4);
    return text.replace("e+", "e").replace(/-/g, "\u2212");
  };

  // The finite range of the values, opened a little where they do not vary.
  function valueRange(values) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of values) {
      if (!Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (low > high) return [-1, 1];
    const size = Math.max(Math.abs(low), Math.abs(high));
    // Single precision: a smaller change is rounding and would fill the chart with noise.
    const least = Math.max(2e-6 * size, 1e-12);
    if (high - low < least) {
      const half = size > 1e-12 ? 0.1 * size : 1;
      return [(low + high) / 2 - half, (low + high) / 2 + half];
    }
    const room = 0.06 * (high - low);
    return [low - room, high + room];
  }

  Gelenk.Chart = class {
    // `pick` is called with the time at the pointer.
    constructor(time, signal, pick) {
      this.signal = signal;
      this.measure(time);
      this.canvas = document.createElement("canvas");
      this.canvas.className = "chart";
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", `${signal.name} over time, from ${Gelenk.valueText(this.range[0])} to ${Gelenk.valueText(this.range[1])} ${signal.unit}`);
      this.still = document.createElement("canvas");
      const choose = (event) => {
        const box = this.canvas.getBoundingClientRect();
        const share = (event.clientX - box.left - this.area.left) / (this.area.right - this.area.left);
        const first = this.time[0];
        pick(first + Math.min(1, Math.max(0, share)) * (this.time[this.time.length - 1] - first));
      };
      this.canvas.addEventListener("pointerdown", (event) => {
        if (event.button !== 0 || !this.area) return;
        this.canvas.setPointerCapture(event.pointerId);
        choose(event);
      });
      this.canvas.addEventListener("pointermove", (event) => {
        if (this.canvas.hasPointerCapture(event.pointerId)) choose(event);
      });
    }

    // Call when the values have become others.
    measure(time) {
      const { values, second } = this.signal;
      this.time = time;
      this.range = valueRange(second ? [...values, ...second] : values);
    }

    x(t) {
      const first = this.time[0];
      const span = this.time[this.time.length - 1] - first || 1;
      return this.area.left + (t - first) / span * (this.area.right - this.area.left);
    }

    y(value) {
      const [low, high] = this.range;
      return this.area.bottom - (value - low) / (high - low) * (this.area.bottom - this.area.top);
    }

    // Draws all that does not move into a canvas of its own: the moving cursor is then cheap.
    prepare(colors) {
      const width = this.canvas.clientWidth;
      const height = this.canvas.clientHeight;
      this.colors = colors;
      this.area = null;
      if (width < 60 || height < 50) return;
      this.ratio = window.devicePixelRatio || 1;
      for (const canvas of [this.canvas, this.still]) {
        canvas.width = Math.round(width * this.ratio);
        canvas.height = Math.round(height * this.ratio);
      }
      const context = this.still.getContext("2d");
      context.scale(this.ratio, this.ratio);
      context.font = font;
      const levels = ticks(this.range[0], this.range[1], Math.max(3, Math.floor((height - 45) / 26)));
      const left = 12 + Math.max(24, ...levels.map((tick) => context.measureText(tick.text).width));
      this.area = { left, right: width - 12, top: 24, bottom: height - 20 };
      const moments = ticks(this.time[0], this.time[this.time.length - 1], Math.max(2, Math.floor((width - left) / 60)));
      context.strokeStyle = colors.edge;
      context.fillStyle = colors.faint;
      context.lineWidth = 1;
      context.beginPath();
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (const tick of levels) {
        const y = Math.round(this.y(tick.value)) + 0.5;
        context.moveTo(left, y);
        context.lineTo(this.area.right, y);
        context.fillText(tick.text, left - 5, y);
      }
      context.textAlign = "center";
      context.textBaseline = "top";
      moments.forEach((tick, i) => {
        const x = Math.round(this.x(tick.value)) + 0.5;
        context.moveTo(x, this.area.bottom);
        context.lineTo(x, this.area.bottom + 4);
        const text = i === moments.length - 1 ? tick.text + " s" : tick.text;
        const half = context.measureText(text).width / 2;
        context.fillText(text, Math.min(x, width - half - 2), this.area.bottom + 6);
      });
      context.stroke();
      context.textAlign = "left";
      context.textBaseline = "middle";
      context.fillStyle = colors.text;
      context.font = "600 " + font;
      // The value at the cursor is at the right end of this line.
      const { name, unit } = this.signal;
      context.fillText(unit ? `${name} [${unit}]` : name, 8, 12, width - 90);
      if (this.signal.second) this.drawLine(context, this.signal.second, colors.second);
      this.drawLine(context, this.signal.values, colors.line);
    }

    drawLine(context, values, color) {
      const { left, right, top, bottom } = this.area;
      context.save();
      context.beginPath();
      context.rect(left, top - 2, right - left + 2, bottom - top + 4);
      context.clip();
      context.strokeStyle = color;
      context.lineWidth = 1.5;
      context.lineJoin = "round";
      context.beginPath();
      let pen = false;
      // Of the many samples within a pixel only the extremes can be seen.
      const crowd = Math.max(1, Math.floor(values.length / (4 * (right - left))));
      for (let k = 0; k < values.length; k += crowd) {
        let low = k;
        let high = k;
        for (let i = k; i < Math.min(values.length, k + crowd); i++) {
          if (values[i] < values[low]) low = i;
          if (values[i] > values[high]) high = i;
        }
        for (const i of low === high ? [low] : [Math.min(low, high), Math.max(low, high)]) {
          const y = this.y(values[i]);
          if (!Number.isFinite(y)) pen = false;
          else if (pen) context.lineTo(this.x(this.time[i]), y);
          else context.moveTo(this.x(this.time[i]), y);
          if (Number.isFinite(y)) pen = true;
        }
      }
      context.stroke();
      context.restore();
    }

    drawDot(context, x, value) {
      if (!Number.isFinite(value)) return;
      context.beginPath();
      context.arc(x, this.y(value), 3, 0, 2 * Math.PI);
      context.fill();
    }

    draw(player) {
      if (!this.area) return;
      const context = this.canvas.getContext("2d");
      const { frame, fraction } = player;
      const at = (values) => (fraction > 0 && frame + 1 < values.length
        ? values[frame] + fraction * (values[frame + 1] - values[frame]) : values[frame]);
      const value = at(this.signal.values);
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      context.drawImage(this.still, 0, 0);
      context.scale(this.ratio, this.ratio);
      const x = Math.min(this.x(player.time), this.area.right);  // curves of a running simulation lag behind
      context.strokeStyle = context.fillStyle = this.colors.cursor;
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(x, this.area.top - 2);
      context.lineTo(x, this.area.bottom);
      context.stroke();
      this.drawDot(context, x, value);
      if (this.signal.second) {
        context.fillStyle = this.colors.second;
        this.drawDot(context, x, at(this.signal.second));
        context.fillStyle = this.colors.cursor;
      }
      context.font = font;
      context.textAlign = "right";
      context.textBaseline = "middle";
      context.fillText(Gelenk.valueText(value), this.area.right, 12);
    }
  };
})();
