// Colours: two scales that are even to the eye and safe for the colour-blind, and a cycle for families.
"use strict";

// Every sixteenth colour of viridis (Smith, van der Walt, CC0) and of cividis (Nunez, Anderton, Renslow, CC0).
const SCALES = {
  viridis:
    "440154 481467 482576 453781 404688 39558c 33638d 2d718e 287d8e 238a8d 1f968b 20a386 29af7f 3dbc74 56c667 75d054 95d840 bade28 dde318 fde725",
  cividis:
    "00224e 002d6c 16396d 2f456b 41506b 515c6d 606871 6c7376 787f7b 868b78 949775 a4a36e b4b066 c5bd5a d7cb49 ead932 fee838",
};

const FAMILY_COLOURS = {
  light: ["#005aa0", "#c85500", "#007d5a", "#be1e5a", "#6e50aa", "#825f14", "#1491b9", "#5a5a5a"],
  dark: ["#6cb4f5", "#ff9a4d", "#3ecf9f", "#ff7aa8", "#b79cf0", "#d9b35c", "#5cd0ee", "#bdbdbd"],
};

function scaleColours(name) {
  return SCALES[name].split(" ").map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));
}

// Colour of a number between 0 and 1 as [r, g, b].
function colourAt(colours, t) {
  const at = Math.min(Math.max(t, 0), 1) * (colours.length - 1);
  const k = Math.min(Math.floor(at), colours.length - 2);
  return colours[k].map((c, n) => Math.round(c + (colours[k + 1][n] - c) * (at - k)));
}

function isDark() {
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

const resolved = new Map();

// A colour of the style sheet as rgb(), for what is drawn by scripts.
function css(name) {
  const key = `${name} ${isDark()}`;
  if (!resolved.has(key)) {
    const probe = document.body.appendChild(document.createElement("span"));
    probe.style.color = `var(${name})`;
    resolved.set(key, getComputedStyle(probe).color);
    probe.remove();
  }
  return resolved.get(key);
}

function familyColour(family) {
  const cycle = FAMILY_COLOURS[isDark() ? "dark" : "light"];
  return cycle[(family - 1) % cycle.length];
}

// A number with few digits.
function digits(value, n = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, exponent] = value.toExponential(Math.max(0, n - 2)).split("e");
    return `${mantissa}·10${raised(Number(exponent))}`.replace("-", "−");
  }
  return String(Number(value.toPrecision(n))).replace("-", "−");
}

function raised(exponent) {
  const signs = { "-": "⁻", 1: "¹", 2: "²", 3: "³" };
  const one = (c) => signs[c] || String.fromCharCode(0x2070 + Number(c));
  return String(exponent).split("").map(one).join("");
}

// About `count` round numbers between two.
function roundTicks(low, high, count) {
  if (!(high > low)) return [low];
  const rough = (high - low) / count;
  const decade = 10 ** Math.floor(Math.log10(rough));
  const step = decade * [1, 2, 5, 10].find((k) => k * decade >= rough * 0.9999);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) ticks.push(k * step || 0);
  return ticks;
}
