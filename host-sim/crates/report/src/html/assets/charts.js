// Puts interactive charts in the place of the page's drawings. Without scripts, and on paper, the drawings stay.
//
// A figure holds its drawing (SVG) and, as JSON, the numbers behind it:
//   kind "time":   panels of one recording over one time axis, zoomed and read together
//   kind "figure": one quantity over another: dots, lines, ranges with their middle
//   kind "rows":   one row for each recording, its error over time, with the located intervals
//   kind "map":    cells over two states; the drawing stays, and tells the cell under the pointer
// Numbers of a series are whole steps from one value to the next ([first, change, change, …]); null is no value.
(function () {
  "use strict";

  var SVG_ONLY = "map";
  // For tests, and for whoever wants the numbers: every chart with the figure it stands in.
  var all = (window.hostSimCharts = []);

  // ---- numbers ----

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

  // ---- looks ----

  var page = getComputedStyle(document.documentElement);
  function colour(name) {
    return page.getPropertyValue("--" + name).trim();
  }

  function stroke(style) {
    return colour("trace-" + style);
  }

  function thickness(style) {
    return style === "recorded" ? 3 : 1.5;
  }

  var FONT = "12px system-ui, sans-serif";
  // All panels of a figure begin at the same place.
  var LEFT = 58;

  /** Marks of the legend: a full square of the trace's colour. */
  function legend(colours) {
    function of(plot, index) { return index > 0 ? colours[index - 1] : "transparent"; }
    return { markers: { width: 2, stroke: of, fill: of } };
  }

  function axis(options) {
    var looks = {
      stroke: colour("ink"),
      font: FONT,
      labelFont: FONT,
      grid: { stroke: colour("grid"), width: 1 },
      ticks: { stroke: colour("grid"), width: 1, size: 5 },
      values: function (plot, values) {
        return values.map(function (value) {
          return value === null ? "" : String(+value.toPrecision(8)).replace("-", "−");
        });
      },
    };
    return Object.assign(looks, options);
  }

  function across(label) {
    return axis(label ? { label: label, labelSize: 20, size: 32 } : { size: 32 });
  }

  function upwards(height) {
    return axis({ size: LEFT, space: height < 120 ? 20 : 32 });
  }

  /** The range of all traces in the part that is shown, switched off or not: nothing jumps when one is switched off. */
  function ofAll(plot) {
    var rows = plot.series[0].idxs || [0, plot.data[0].length - 1];
    var low = Infinity, high = -Infinity;
    plot.data.slice(1).forEach(function (values) {
      for (var row = rows[0]; row <= rows[1]; row++) {
        var value = values[row];
        if (value === null || value === undefined || !isFinite(value)) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    });
    return low > high ? [0, 1] : uPlot.rangeNum(low, high, 0.1, true);
  }

  // ---- zoom without a mouse ----

  /** Shows a part of the time, within what is recorded; null shows all. */
  function show(plot, from, to) {
    var times = plot.data[0], first = times[0], last = times[times.length - 1];
    if (from === null || to - from >= last - first) { from = first; to = last; }
    if (from < first) { to += first - from; from = first; }
    if (to > last) { from -= to - last; to = last; }
    if (to > from) plot.setScale("x", { min: from, max: to });
  }

  /** Keys of a chart that has the focus: + and −, arrows, 0 or Escape for all. */
  function keys(place, plot) {
    place.tabIndex = 0;
    place.setAttribute("role", "group");
    place.setAttribute("aria-label", "chart: + and - zoom, arrows move, 0 shows all");
    place.addEventListener("keydown", function (event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      var from = plot.scales.x.min, to = plot.scales.x.max, part = (to - from) / 4;
      if (event.key === "+" || event.key === "=") show(plot, from + part, to - part);
      else if (event.key === "-") show(plot, from - 2 * part, to + 2 * part);
      else if (event.key === "ArrowLeft") show(plot, from - part, to - part);
      else if (event.key === "ArrowRight") show(plot, from + part, to + part);
      else if (event.key === "0" || event.key === "Escape") show(plot, null, null);
      else return;
      event.preventDefault();
    });
  }

  /** A finger that moves sideways chooses a part; one that moves up or down scrolls the page; a double tap shows all. */
  function fingers(plot) {
    var over = plot.over, began = null;
    over.style.touchAction = "pan-y";
    function at(event) { return Math.min(Math.max(event.clientX - over.getBoundingClientRect().left, 0), over.clientWidth); }
    function choose(left, right) {
      plot.setSelect({ left: left, top: 0, width: right - left, height: right > left ? over.clientHeight : 0 }, false);
    }
    over.addEventListener("pointerdown", function (event) {
      if (event.pointerType === "touch") began = at(event);
    });
    over.addEventListener("pointermove", function (event) {
      if (began !== null && event.pointerType === "touch") choose(Math.min(began, at(event)), Math.max(began, at(event)));
    });
    over.addEventListener("pointerup", function (event) {
      if (began === null || event.pointerType !== "touch") return;
      var left = Math.min(began, at(event)), right = Math.max(began, at(event));
      began = null;
      choose(0, 0);
      if (right - left > 15) show(plot, plot.posToVal(left, "x"), plot.posToVal(right, "x"));
    });
    over.addEventListener("pointercancel", function () { began = null; choose(0, 0); });
  }

  /** Shaded rectangles under the traces, each [left, right, bottom, top] in values; null reaches to the edge. */
  function shades(rectangles) {
    return function (plot) {
      var box = plot.bbox;
      var ink = plot.ctx;
      ink.save();
      ink.beginPath();
      ink.rect(box.left, box.top, box.width, box.height);
      ink.clip();
      ink.fillStyle = colour("shade");
      rectangles.forEach(function (edges) {
        var x = [edges[0], edges[1]].map(function (value, end) {
          return value === null ? box.left + end * box.width : plot.valToPos(value, "x", true);
        });
        var y = [edges[2], edges[3]].map(function (value, end) {
          return value === null ? box.top + (1 - end) * box.height : plot.valToPos(value, "y", true);
        });
        // An interval shorter than a pixel still shows.
        ink.fillRect(x[0], y[1], Math.max(x[1] - x[0], 2), y[0] - y[1]);
      });
      ink.restore();
    };
  }

  function element(tag, name, text) {
    var made = document.createElement(tag);
    if (name) made.className = name;
    if (text) made.textContent = text;
    return made;
  }

  // ---- charts over time ----

  /** What is recorded less each simulation. */
  function residuals(traces, series) {
    var recorded = traces.findIndex(function (trace) { return trace.style === "recorded"; });
    var found = [];
    traces.forEach(function (trace, index) {
      if (recorded < 0 || trace.style === "recorded" || trace.style === "input") return;
      var values = series[index].map(function (value, row) {
        return value === null || series[recorded][row] === null ? null : series[recorded][row] - value;
      });
      found.push({ label: trace.label, style: trace.style, values: values });
    });
    return found;
  }

  function overTime(place, data, width) {
    var shown = [];
    var busy = false;
    var name = "time-" + all.length;

    /** Does the same on all other charts of the figure, once. */
    function together(plot, act) {
      if (busy) return;
      busy = true;
      shown.forEach(function (other) { if (other !== plot) act(other); });
      busy = false;
    }

    function chart(title, unit, time, traces, shade, height, last, note) {
      place.appendChild(element("p", "panel", title));
      if (note) place.appendChild(element("p", isAlone(traces) ? "remark" : "quantity", note));
      var options = {
        width: width,
        height: height + (last ? 50 : 28),
        scales: { x: { time: false }, y: { range: ofAll } },
        legend: legend(traces.map(function (trace) { return stroke(trace.style); })),
        cursor: {
          drag: { x: true, y: false },
          sync: { key: name, filters: { pub: function (type) { return type === "mousemove" || type === "mouseleave"; } } },
        },
        axes: [last ? across("time [s]") : across(), upwards(height)],
        series: [{ label: "time", value: function (plot, value) { return withUnit(value, "s"); } }].concat(
          traces.map(function (trace) {
            return {
              label: trace.label,
              stroke: stroke(trace.style),
              width: thickness(trace.style),
              points: { show: false },
              value: function (plot, value) { return withUnit(value, unit); },
            };
          })
        ),
        hooks: {
          drawClear: [shades(shade.map(function (ends) { return [ends[0], ends[1], null, null]; }))],
          setScale: [function (plot, key) {
            if (key !== "x") return;
            var range = { min: plot.scales.x.min, max: plot.scales.x.max };
            together(plot, function (other) { other.setScale("x", range); });
          }],
          setSeries: [function (plot, index, changed) {
            if (index === null || changed.show === undefined) return;
            var label = plot.series[index].label;
            together(plot, function (other) {
              other.series.forEach(function (series, at) {
                if (at > 0 && series.label === label) other.setSeries(at, { show: changed.show });
              });
            });
          }],
        },
      };
      var plot = new uPlot(options, [time].concat(traces.map(function (trace) { return trace.values; })), place);
      shown.push(plot);
      fingers(plot);
    }

    function isAlone(traces) {
      return traces.every(function (trace) { return trace.style === "input" || trace.style === "channel"; });
    }

    data.panels.forEach(function (panel, index) {
      var last = index + 1 === data.panels.length;
      var time = times(panel.time);
      var series = panel.traces.map(unpacked);
      var traces = panel.traces.map(function (trace, at) {
        return { label: trace.label, style: trace.style, values: series[at] };
      });
      var missed = residuals(panel.traces, series);
      chart(panel.title + " [" + panel.unit + "]", panel.unit, time, traces, panel.shade, isAlone(traces) ? 110 : 170, last && !missed.length, panel.note);
      if (missed.length) {
        chart("recorded − simulated [" + panel.unit + "]", panel.unit, time, missed, panel.shade, 112, last);
      }
    });
    if (shown.length) keys(place, shown[0]);
    return shown;
  }

  // ---- one quantity over another ----

  function overState(place, data, width) {
    var xTitle = parts(data.x), yTitle = parts(data.y);
    place.appendChild(element("p", "panel", data.title));
    // uPlot wants one row of x for all layers: every point gets a row of its own, where the others have none.
    var rows = [];
    data.layers.forEach(function (layer, index) {
      layer.points.forEach(function (point, order) { rows.push([point[0], index, point, order]); });
    });
    rows.sort(function (a, b) { return a[0] - b[0] || a[1] - b[1] || a[3] - b[3]; });
    var columns = data.layers.map(function () { return rows.map(function () { return null; }); });
    rows.forEach(function (row, at) { columns[row[1]][at] = row[2].length > 2 ? row[2][2] : row[2][1]; });

    /** The first layer of its kind: the one itself unless it has no name. */
    function lead(index) {
      var layer = data.layers[index];
      if (layer.label) return index;
      return data.layers.findIndex(function (other) {
        return other.style === layer.style && (other.marks === "bins") === (layer.marks === "bins");
      });
    }

    function ofLayer(layer) {
      return layer.marks === "bins" ? colour("ink") : stroke(layer.style);
    }

    function whiskers(plot) {
      var ink = plot.ctx;
      ink.save();
      ink.strokeStyle = colour("ink");
      ink.lineWidth = window.devicePixelRatio || 1;
      data.layers.forEach(function (layer, index) {
        if (layer.marks !== "bins" || !plot.series[index + 1].show) return;
        layer.points.forEach(function (point) {
          var x = plot.valToPos(point[0], "x", true);
          if (x < plot.bbox.left || x > plot.bbox.left + plot.bbox.width) return;
          ink.beginPath();
          ink.moveTo(x, plot.valToPos(point[1], "y", true));
          ink.lineTo(x, plot.valToPos(point[3], "y", true));
          ink.stroke();
        });
      });
      ink.restore();
    }

    var options = {
      width: Math.min(width, 680),
      height: 350,
      scales: { x: { time: false }, y: { range: ofAll } },
      legend: legend(data.layers.map(ofLayer)),
      cursor: {
        drag: { x: true, y: true, uni: 12 },
        // The nearest row in which the layer has a value.
        dataIdx: function (plot, series, index) {
          var values = plot.data[series];
          if (series === 0 || values[index] !== null) return index;
          for (var off = 1; off < values.length; off++) {
            if (values[index - off] !== null && values[index - off] !== undefined) return index - off;
            if (values[index + off] !== null && values[index + off] !== undefined) return index + off;
          }
          return index;
        },
      },
      axes: [across(data.x), upwards(380)],
      series: [{ label: xTitle[0], value: function (plot, value) { return withUnit(value, xTitle[1]); } }].concat(
        data.layers.map(function (layer, index) {
          var dots = layer.marks !== "line";
          var ink = ofLayer(layer);
          return {
            label: layer.label || (layer.marks === "bins" ? "middle half" : "other branch"),
            // A further branch has no place in the legend: it goes with the first.
            class: lead(index) === index ? null : "branch",
            stroke: ink,
            width: dots ? 0 : 2,
            paths: dots ? function () { return null; } : undefined,
            spanGaps: true,
            points: { show: dots, size: layer.marks === "bins" ? 6 : 4, fill: ink, width: 0 },
            value: function (plot, value) { return withUnit(value, yTitle[1]); },
          };
        })
      ),
      hooks: {
        drawClear: data.band === null ? [] : [shades([[null, null, -data.band, data.band]])],
        draw: [whiskers],
        setSeries: [function (plot, index, changed) {
          if (index === null || changed.show === undefined || lead(index - 1) !== index - 1) return;
          data.layers.forEach(function (layer, at) {
            if (at !== index - 1 && lead(at) === index - 1) plot.setSeries(at + 1, { show: changed.show });
          });
        }],
      },
    };
    place.appendChild(element("p", "quantity", data.y));
    return [new uPlot(options, [rows.map(function (row) { return row[0]; })].concat(columns), place)];
  }

  // ---- one row for each recording ----

  function inRows(place, data, width) {
    place.appendChild(element("p", "panel", data.title));
    var count = data.rows.length;
    // Row 0 is on top. Values reach from the row's base to 0.85 above it.
    function base(row) { return count - 1 - row; }
    var series = [{ label: "time" }];
    var columns = [times(data.time)];
    var marked = [], traces = [];
    data.rows.forEach(function (row, index) {
      row.shade.forEach(function (ends) { marked.push([ends[0], ends[1], base(index), base(index) + 0.95]); });
      row.traces.forEach(function (trace) {
        var values = unpacked(trace);
        columns.push(values.map(function (value) {
          return value === null ? null : base(index) + (0.85 * Math.min(value, data.most)) / data.most;
        }));
        series.push({ label: trace.label, stroke: stroke(trace.style), width: 1.25, points: { show: false } });
        traces.push({ row: index, label: trace.label, style: trace.style, values: values });
      });
    });

    // A legend of all rows would be long: one switch for each kind of trace, and a line for the row under the pointer.
    var switches = element("p", "switches");
    var told = element("span", "soft", "");
    var plot;
    function tell() {
      var at = plot.cursor.idx, row = base(Math.floor(plot.posToVal(plot.cursor.top, "y")));
      var here = traces.filter(function (trace) { return trace.row === row; });
      var known = at !== null && at !== undefined && plot.cursor.left >= 0 && here.length;
      told.textContent = known
        ? data.rows[row].label + " at " + withUnit(plot.data[0][at], "s") + ": " + here.map(function (trace) {
          return trace.label + " " + withUnit(trace.values[at], data.unit);
        }).join(", ")
        : "";
    }
    data.rows.length && data.rows[0].traces.forEach(function (trace) {
      var button = switches.appendChild(element("button", "", trace.label));
      button.type = "button";
      button.style.setProperty("--mark", stroke(trace.style));
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", function () {
        var show = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(show));
        plot.series.forEach(function (one, index) {
          if (index > 0 && one.label === trace.label) plot.setSeries(index, { show: show });
        });
      });
    });
    switches.appendChild(told);

    var longest = Math.max.apply(null, data.rows.map(function (row) { return row.label.length; }).concat(1));
    var options = {
      width: width,
      height: 54 + 46 * count,
      scales: { x: { time: false }, y: { range: [0, count] } },
      legend: { show: false },
      cursor: { drag: { x: true, y: false }, y: false, points: { show: false } },
      axes: [
        across("time [s]"),
        axis({
          size: Math.min(120, Math.max(LEFT, 14 + 6.6 * longest)),
          splits: function () { return data.rows.map(function (row, index) { return index; }); },
          values: function (plot, splits) {
            return splits.map(function (at) {
              var label = data.rows[base(at)].label;
              return label.length > 16 ? label.slice(0, 15) + "…" : label;
            });
          },
        }),
      ],
      series: series,
      hooks: { drawClear: [shades(marked)], setCursor: [tell] },
    };
    plot = new uPlot(options, columns, place);
    place.appendChild(switches);
    keys(place, plot);
    fingers(plot);
    return [plot];
  }

  // ---- cells over two states ----

  /** The drawing stays; a line below it tells what is under the pointer. */
  function onMap(figure, data) {
    var drawing = figure.querySelector("svg");
    var told = figure.querySelector(".told") || figure.appendChild(element("p", "told soft", "\u00a0"));
    drawing.addEventListener("pointermove", function (event) {
      var box = drawing.getBoundingClientRect();
      var x = ((event.clientX - box.left) / box.width) * data.width;
      var y = ((event.clientY - box.top) / box.height) * data.height;
      var column = Math.floor(((x - data.left) / (data.right - data.left)) * data.columns);
      var row = Math.floor(((data.bottom - y) / (data.bottom - data.top)) * data.rows);
      var inside = column >= 0 && column < data.columns && row >= 0 && row < data.rows;
      var cell = inside ? data.cells[row * data.columns + column] : null;
      told.textContent = cell
        ? data.x + " " + readable(data.from[0] + column * data.step[0]) + " to " + readable(data.from[0] + (column + 1) * data.step[0]) +
          ", " + data.y + " " + readable(data.from[1] + row * data.step[1]) + " to " + readable(data.from[1] + (row + 1) * data.step[1]) +
          ": " + readable(cell[0]) + " " + data.unit + ", " + cell[1] + " rows"
        : "\u00a0";
    });
  }

  // ---- the page ----

  var KINDS = { time: overTime, figure: overState, rows: inRows };

  function widthOf(figure) {
    return Math.max(240, Math.floor(figure.getBoundingClientRect().width));
  }

  /** Draws a figure's charts, unless it has them or is folded away. */
  function live(figure) {
    if (figure.classList.contains("live") || figure.closest("details:not([open])")) return;
    var data = JSON.parse(figure.querySelector("script").textContent);
    if (data.kind === SVG_ONLY) {
      figure.classList.add("live", "drawn");
      onMap(figure, data);
      return;
    }
    var place = element("div", "plots");
    figure.appendChild(place);
    var plots;
    try {
      plots = KINDS[data.kind](place, data, widthOf(figure));
    } catch (error) {
      // The drawing stays, and so do all other charts.
      place.remove();
      figure.classList.remove("data");
      console.error(error);
      return;
    }
    plots.forEach(function (plot) { all.push({ figure: figure, kind: data.kind, plot: plot, most: plot.width }); });
    figure.classList.add("live");
  }

  function remove(figure) {
    for (var index = all.length - 1; index >= 0; index--) {
      if (all[index].figure === figure) all.splice(index, 1)[0].plot.destroy();
    }
    var place = figure.querySelector(".plots");
    if (place) place.remove();
    if (!figure.classList.contains("drawn")) figure.classList.remove("live");
  }

  var figures = Array.prototype.slice.call(document.querySelectorAll("figure.data"));

  function again() {
    figures.forEach(remove);
    figures.forEach(live);
  }

  // What is folded is drawn when it is opened.
  document.querySelectorAll("details").forEach(function (folded) {
    folded.addEventListener("toggle", function () {
      if (folded.open) folded.querySelectorAll("figure.data").forEach(live);
    });
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  var width = document.documentElement.clientWidth;
  window.addEventListener("resize", function () {
    if (document.documentElement.clientWidth === width) return;
    width = document.documentElement.clientWidth;
    all.forEach(function (one) {
      var room = widthOf(one.figure);
      one.plot.setSize({ width: one.kind === "figure" ? Math.min(room, 680) : room, height: one.plot.height });
    });
  });
  figures.forEach(live);

  // In a frame that has its page as text, a link to a place within the page would lead out of it.
  document.querySelectorAll(".contents a").forEach(function (link) {
    link.addEventListener("click", function (event) {
      event.preventDefault();
      document.getElementById(link.hash.slice(1)).scrollIntoView();
    });
  });
})();
