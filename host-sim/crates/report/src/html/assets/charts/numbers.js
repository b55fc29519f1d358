// Numbers as the page packs them, and as people read them.

/** A series from its steps. */
function unpacked(packed) {
  var at = packed.from;
  return packed.steps.map(function (step) {
    if (step === null) return null;
    at += step;
    return at * packed.unit;
  });
}

/** Times from a start and an interval, or from their own steps. */
function times(packed) {
  if (packed.steps) return unpacked(packed);
  var found = [];
  for (var row = 0; row < packed.rows; row++) found.push(packed.from + row * packed.interval);
  return found;
}

/** A number with about five digits, as people write it. */
function readable(value) {
  if (value === null || value === undefined || !isFinite(value)) return "";
  var size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(3);
  var decimals = size === 0 ? 0 : Math.max(0, Math.min(6, 4 - Math.floor(Math.log10(size))));
  return value.toFixed(decimals).replace("-", "−");
}

function withUnit(value, unit) {
  var text = readable(value);
  return unit && text !== "" ? text + " " + unit : text;
}

/** "velocity [mm/s]" → ["velocity", "mm/s"]. */
function parts(title) {
  var found = /^(.*) \[(.*)\]$/.exec(title);
  return found ? [found[1], found[2]] : [title, ""];
}
