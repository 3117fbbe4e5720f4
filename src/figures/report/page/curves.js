// Curves by uPlot: axes with units, a marker at the cursor, a click or the arrow keys to move it.
"use strict";

class Curve {
  // `pick` is called with the place on the x axis that was chosen.
  constructor(host, name, pick) {
    this.host = host;
    this.pick = pick;
    this.marker = null;
    this.plot = null;
    this.key = "";
    host.setAttribute("role", "img");
    host.setAttribute("aria-label", name);
    new ResizeObserver(() => this.resize()).observe(host);
  }

  // x ascending; series: [{ label, values, colour, dash, points, width }]; axes: { x, y } labels; log heights or not.
  show(x, series, axes, log) {
    this.series = series;
    const style = series.map((s) => [s.label, s.colour, s.dash, s.points, s.width]);
    const key = JSON.stringify([style, axes, log, css("--ink")]);
    const data = [x, ...series.map((s) => s.values)];
    if (this.plot && key === this.key) {
      this.plot.setData(data);
      return;
    }
    this.key = key;
    if (this.plot) this.plot.destroy();
    this.plot = new uPlot(this.options(series, axes, log), data, this.host);
    this.plot.over.addEventListener("click", () => {
      const { left } = this.plot.cursor;
      if (left >= 0 && this.pick) this.pick(this.plot.posToVal(left, "x"));
    });
  }

  options(series, axes, log) {
    const ink = css("--ink");
    const axis = (label, size) => ({
      label,
      stroke: ink,
      font: "12px system-ui, sans-serif",
      labelFont: "12px system-ui, sans-serif",
      labelSize: 20,
      size,
      grid: { stroke: css("--grid"), width: 1 },
      ticks: { stroke: css("--grid"), width: 1 },
    });
    const values = log
      ? (plot, splits) => {
          const few = Math.log10(plot.scales.y.max / plot.scales.y.min) < 2;
          const leading = (v) => Math.round(v / 10 ** Math.floor(Math.log10(v) + 1e-9));
          const marked = (v) => (few ? [1, 2, 5] : [1]).includes(leading(v));
          return splits.map((v) => (v !== null && marked(v) ? digits(v, 2) : ""));
        }
      : (plot, splits) => splits.map((v) => digits(v, 5));
    return {
      width: Math.max(200, this.host.clientWidth),
      height: Math.max(140, this.host.clientHeight),
      legend: { show: false },
      pxAlign: 0,
      cursor: { drag: { x: true, y: false }, points: { size: 5 } },
      scales: { x: { time: false }, y: log ? { distr: 3 } : {} },
      axes: [axis(axes.x, 40), { ...axis(axes.y, 72), values }],
      series: [
        {},
        ...series.map((s) => ({
          label: s.label,
          stroke: s.colour,
          width: s.width ?? 1.6,
          dash: s.dash,
          points: { show: Boolean(s.points), size: 4, stroke: s.colour },
          paths: s.points ? () => null : undefined,
        })),
      ],
      hooks: { draw: [(plot) => this.drawMarker(plot)] },
    };
  }

  setMarker(x) {
    this.marker = x;
    if (this.plot) this.plot.redraw(false);
  }

  drawMarker(plot) {
    if (this.marker === null) return;
    const { ctx, bbox } = plot;
    const x = plot.valToPos(this.marker, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.save();
    ctx.strokeStyle = css("--cursor");
    ctx.lineWidth = 1.5 * devicePixelRatio;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  resize() {
    if (!this.plot) return;
    this.plot.setSize({ width: Math.max(200, this.host.clientWidth), height: Math.max(140, this.host.clientHeight) });
  }
}
