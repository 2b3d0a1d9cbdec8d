// Draws the figures of a page by Vega. A figure is JSON of study/plot.hpp: panels in a grid, each with axes and layers.
'use strict';
const kInk = '#1f262e', kMuted = '#66707c', kGrid = '#e4e8ec', kNoValue = '#bdbdbd';
const isNumber = value => typeof value === 'number';
const shown = value => !isNumber(value) ? 'none' : String(Number(value.toPrecision(4))).replace('-', '−');

// ---- scales --------------------------------------------------------------------------------------------------------

function xsOf(layer) {
  return Array.isArray(layer.x) ? layer.x : layer.y.map((_, i) => layer.x.from + layer.x.step * i);
}

// Return all values that an axis must show.
function valuesOf(layer, axis) {
  switch (layer.type) {
    case 'line': case 'points': return axis === 'x' ? xsOf(layer) : layer.y;
    case 'level': return axis === 'y' ? [layer.y] : [];
    case 'mark': return axis === 'x' ? [layer.x] : [];
    case 'cells': return layer.cells.flatMap(cell => axis === 'x' ? [cell.x0, cell.x1] : [cell.y0, cell.y1]);
    case 'boxes': return axis === 'y' ? layer.boxes.flatMap(box => box.values) : [];
    case 'intervals': return axis === 'x' ? layer.rows.flatMap(row => [row.low, row.high]) : [];
    default: return [];
  }
}

function domainOf(panel, axis, figure) {
  const settings = panel[axis];
  if (isNumber(settings.low)) return [settings.low, settings.high];
  const alike = settings.share ? figure.panels.filter(other => other[axis].share === settings.share) : [panel];
  const values = alike.flatMap(other => other.layers.flatMap(layer => valuesOf(layer, axis)))
    .filter(value => isNumber(value) && (!settings.log || value > 0));
  if (values.length === 0) return settings.log ? [0.1, 1] : [0, 1];
  let low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
  const margin = settings.margin ?? 0.06;
  if (settings.log) {
    const factor = high > low ? (high / low) ** margin : 1.05;
    return [low / factor, high * factor];
  }
  const more = high > low ? margin * (high - low) : high === 0 ? 1 : 0.05 * Math.abs(high);
  return [low - more, high + more];
}

function scaleOf(name, settings, signal) {
  const range = name === 'x' ? 'width' : 'height';
  if (settings.names) return {name, type: 'band', domain: settings.names, range, padding: 0.1};
  return {name, type: settings.log ? 'log' : 'linear', domain: {signal}, range, nice: false, ...(settings.log ? {} : {zero: false})};
}

// Return 1, 2 and 5 times powers of ten, or every power if there are many.
function logTicks([low, high]) {
  const decades = Math.log10(high / low), every = Math.ceil(decades / 8), ticks = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; ++power)
    for (const factor of decades < 2.7 ? [1, 2, 5] : power % every === 0 ? [1] : [])
      if (factor * 10 ** power >= low && factor * 10 ** power <= high) ticks.push(factor * 10 ** power);
  return ticks;
}

function axisOf(name, settings, panel, domain) {
  const numbers = settings.numbers !== false, length = name === 'x' ? panel.width : panel.height;
  return {scale: name, orient: name === 'x' ? 'bottom' : 'left', title: numbers ? settings.title || null : null,
    labels: numbers, ticks: numbers && !settings.names, grid: !settings.names && panel.grid !== false, domain: false, labelLimit: 300,
    tickCount: Math.max(2, Math.round(length / (name === 'x' ? 55 : 45))), labelOverlap: true,
    ...(settings.log ? {format: '~g', values: logTicks(domain)} : {})};
}

// ---- layers --------------------------------------------------------------------------------------------------------

const at = (scale, field) => ({scale, field}), is = value => ({value}), by = field => ({field});
const mark = (type, data, update) => ({type, ...(data ? {from: {data}} : {}), encode: {update}});
const styled = layer => ({stroke: is(layer.colour || kInk), strokeWidth: is(layer.width || 1.5), strokeDash: is(layer.dash || [])});
const xy = {x: at('x', 'x'), y: at('y', 'y')}, tip = {tooltip: by('text')};
const corners = {x: at('x', 'x0'), x2: at('x', 'x1'), y: at('y', 'y0'), y2: at('y', 'y1')};

// Box plots after Tukey (1977): median, quartiles, whiskers to the farthest value within 1.5 interquartile ranges.
function boxMarks(layer, table) {
  const series = [...new Set(layer.boxes.map(box => box.series))], boxes = [], points = [], empty = [];
  const many = layer.boxes.reduce((sum, box) => sum + box.values.length, 0) > 1500;  // then draw only those outside
  for (const {group, series: name, colour, dash, values, texts} of layer.boxes) {
    const base = {group, colour, dash, place: (series.indexOf(name) + 0.5) / series.length};
    const sorted = values.filter(value => value > 0).sort((a, b) => a - b), title = name + (group ? ', ' + group : '');
    if (sorted.length === 0) {
      empty.push({...base, text: title + ': no values'});
      continue;
    }
    const [q1, median, q3] = vega.quartiles(sorted), reach = 1.5 * (q3 - q1);
    const inside = sorted.filter(value => value >= q1 - reach && value <= q3 + reach);
    const low = Math.min(q1, inside[0]), high = Math.max(q3, inside[inside.length - 1]);
    boxes.push({...base, q1, median, q3, low, high, text: `${title}: median ${shown(median)}, quartiles ${shown(q1)} to ` +
      `${shown(q3)}, ${sorted.length} values ${shown(sorted[0])} to ${shown(sorted[sorted.length - 1])}`});
    values.forEach((value, i) => {
      if (value > 0 && !(many && value >= low && value <= high))
        points.push({...base, value, shift: ((i * 0.618034) % 1 - 0.5) * 0.5, text: `${name}, ${texts ? texts[i] : shown(value)}`});
    });
  }
  const wide = `min(34, 0.8 * bandwidth('x') / ${series.length})`, own = by('colour'), boxTable = table(boxes);
  const middle = "scale('x', datum.group) + datum.place * bandwidth('x')";
  const body = {xc: {signal: middle}, width: {signal: wide}, fill: own, ...tip};
  return [
    mark('rule', boxTable, {x: {signal: middle}, y: at('y', 'low'), y2: at('y', 'high'), stroke: own}),
    mark('rect', boxTable, {...body, y: at('y', 'q1'), y2: at('y', 'q3'), fillOpacity: is(0.25), stroke: own, strokeDash: by('dash')}),
    mark('rect', boxTable, {...body, y: {...at('y', 'median'), offset: -1}, height: is(2.4)}),
    mark('symbol', table(points), {x: {signal: `${middle} + datum.shift * ${wide}`}, y: at('y', 'value'), size: is(9), fill: own,
      fillOpacity: is(0.7), ...tip}),
    mark('text', table(empty), {x: {signal: middle}, y: {signal: 'height - 4'}, angle: is(-90), baseline: is('middle'),
      text: is('none'), fill: own, ...tip})];
}

// Return the marks of a layer; `table` adds rows to the panel and returns their name.
function marksOf(layer, table) {
  switch (layer.type) {
    case 'line': {
      const data = table(xsOf(layer).map((x, i) => ({x, y: layer.y[i]})));
      const line = mark('line', data, {...xy, ...styled(layer), defined: {signal: 'isValid(datum.y)'}});
      return layer.marks ? [line, mark('symbol', data, {...xy, size: is(40), fill: is(layer.colour)})] : [line];
    }
    case 'level': return [mark('rule', null, {x: is(0), x2: {signal: 'width'}, y: {scale: 'y', value: layer.y}, ...styled(layer)})];
    case 'mark': return [mark('rule', null, {y: is(0), y2: {signal: 'height'}, x: {scale: 'x', value: layer.x}, ...styled(layer)})];
    case 'cells':
      return [mark('rect', table(layer.cells), {...corners, ...tip, fill: [{test: 'isValid(datum.colour)', field: 'colour'},
        {test: 'isValid(datum.value)', scale: 'colour', field: 'value'}, is(kNoValue)]})];
    case 'points': {
      const rows = layer.x.map((x, i) => ({x, y: layer.y[i], text: layer.texts && layer.texts[i]}));
      return [mark('symbol', table(rows), {...xy, size: is(layer.size || 30), fill: is(layer.colour), ...tip})];
    }
    case 'segments':
      return [mark('rule', table(layer.segments), {...corners, stroke: by('colour'), strokeWidth: by('width'), strokeCap: is('round')})];
    case 'texts':
      return [mark('text', table(layer.texts), {...xy, dy: is(-10), align: by('align'), text: by('text'), fontSize: is(12),
        fill: is(kMuted)})];
    case 'boxes': return boxMarks(layer, table);
    case 'intervals': {
      const data = table(layer.rows), y = {scale: 'y', field: 'name', band: 0.5};
      return [mark('rule', data, {x: at('x', 'low'), x2: at('x', 'high'), y, stroke: by('colour'), strokeWidth: is(3), ...tip}),
        mark('symbol', data, {x: at('x', 'mean'), y, size: is(70), fill: by('colour'), ...tip})];
    }
    default: throw new Error('unknown layer ' + layer.type);
  }
}

// ---- panels --------------------------------------------------------------------------------------------------------

function panelMark(panel, k, figure) {
  const data = [];
  const table = values => {
    data.push({name: `table${k}_${data.length}`, values});
    return data[data.length - 1].name;
  };
  const size = {width: is(panel.width), height: is(panel.height)}, marks = panel.layers.flatMap(layer => marksOf(layer, table));
  // Under the mouse this rectangle shows the values of all lines at one x, and a drag zooms in.
  if (panel.layers.some(layer => layer.type === 'line'))
    marks.push({...mark('rect', null, {...size, fill: is('transparent'), tooltip: is({panel: k}), cursor: is('crosshair')}), name: `sheet${k}`});
  const title = {text: panel.title, frame: 'group', fontWeight: 'normal', fontSize: 13, color: kInk, limit: panel.width, offset: 6};
  return {type: 'group', encode: {enter: size}, data, ...(panel.title ? {title} : {}),
    signals: [{name: 'width', value: panel.width}, {name: 'height', value: panel.height}],
    scales: [scaleOf('x', panel.x, `domain${k}`), scaleOf('y', panel.y, `heights${k}`)],
    axes: ['x', 'y'].map(name => axisOf(name, panel[name], panel, domainOf(panel, name, figure))),
    marks: [{type: 'group', clip: true, encode: {enter: size}, marks},
      {...mark('rect', null, {...size, stroke: is(kMuted)}), interactive: false}]};
}

// A drag along x zooms in, a double click shows everything again.
function signalsOf(figure) {
  return figure.panels.flatMap((panel, k) => {
    const all = domainOf(panel, 'x', figure), share = `clamp(x(group()) / ${panel.width}, 0, 1)`;
    const [low, high, from, to] = [`domain${k}[0]`, `domain${k}[1]`, `drag${k}[0]`, `drag${k}[1]`];
    const place = at => panel.x.log ? `${low} * pow(${high} / ${low}, ${at})` : `${low} + ${at} * (${high} - ${low})`;
    return [
      {name: `heights${k}`, value: domainOf(panel, 'y', figure)},
      {name: `drag${k}`, value: [0, 0], on: [
        {events: `@sheet${k}:mousedown`, update: `[${share}, ${share}]`},
        {events: `[@sheet${k}:mousedown, window:mouseup] > @sheet${k}:mousemove`, update: `[${from}, ${share}]`}]},
      {name: `domain${k}`, value: all, on: [
        {events: `@sheet${k}:mouseup`, update: `abs(${to} - ${from}) > 0.02 ? ` +
          `[${place(`min(${from}, ${to})`)}, ${place(`max(${from}, ${to})`)}] : domain${k}`},
        {events: `@sheet${k}:dblclick`, update: JSON.stringify(all)}]}];
  });
}

function specOf(figure) {
  const entries = figure.legend || [], scales = [], legends = [];
  if (entries.length > 0) {
    const domain = entries.map(entry => entry.name), dashes = entries.map(entry => entry.dash);
    scales.push({name: 'names', type: 'ordinal', domain, range: entries.map(entry => entry.colour)},
      {name: 'dashes', type: 'ordinal', domain, range: dashes});
    const filled = {fill: 'names', symbolType: 'square', symbolSize: 150, symbolOpacity: dashes.some(dash => dash.length > 0) ? 0.5 : 1};
    legends.push({stroke: 'names', strokeDash: 'dashes', orient: 'top', direction: 'horizontal', columns: Math.min(domain.length, 3),
      labelLimit: 400, labelFontSize: 13,
      ...(entries[0].filled ? filled : {symbolType: 'stroke', symbolSize: 400, symbolStrokeWidth: 2.5})});
  }
  if (figure.scale) {
    const {log, title, low, high} = figure.scale;
    scales.push({name: 'colour', type: log ? 'log' : 'linear', domain: [low, high], range: {scheme: 'viridis'}});
    legends.push({fill: 'colour', type: 'gradient', title, orient: 'right', gradientLength: figure.panels[0].height, format: '~g',
      titleLimit: 300});
  }
  const plain = {labelFontSize: 12, titleFontSize: 13, titleFontWeight: 'normal'};
  return {description: figure.label, padding: 5, signals: signalsOf(figure), scales, legends,
    layout: {columns: figure.columns, padding: {row: 14, column: 18}, bounds: 'full', align: 'each'},
    marks: figure.panels.map((panel, k) => panelMark(panel, k, figure)),
    config: {axis: {...plain, labelColor: kMuted, titleColor: kInk, gridColor: kGrid, tickColor: kMuted}, legend: plain}};
}

// ---- the page ------------------------------------------------------------------------------------------------------

const tooltip = document.createElement('div');
tooltip.className = 'tooltip';
tooltip.setAttribute('role', 'status');
document.body.append(tooltip);

// Return the values of a panel's lines at a share of its width.
function textAt(panel, share, [low, high]) {
  const x = panel.x.log ? low * (high / low) ** share : low + share * (high - low);
  const lines = panel.layers.filter(layer => layer.type === 'line').map(layer => {
    const xs = xsOf(layer);
    let nearest = 0;
    xs.forEach((value, i) => { if (Math.abs(value - x) < Math.abs(xs[nearest] - x)) nearest = i; });
    return `${layer.name || panel.title}: ${shown(layer.y[nearest])}`;
  });
  return [`${panel.x.title || 'x'}: ${shown(x)}`, ...lines].join('\n');
}

function showTooltip(figure, view) {
  return (handler, event, item, value) => {
    let text = value;
    if (value && isNumber(value.panel)) {
      const box = event.target.getBoundingClientRect();
      text = textAt(figure.panels[value.panel], (event.clientX - box.left) / box.width, view().signal(`domain${value.panel}`));
    }
    tooltip.textContent = text || '';
    tooltip.style.display = text ? 'block' : 'none';
    const left = Math.min(event.clientX + 14, innerWidth - tooltip.offsetWidth - 8);
    tooltip.style.left = `${Math.max(8, left)}px`;
    tooltip.style.top = `${event.clientY + 18}px`;
  };
}

// Lower the index of a symbol: "K_z1" becomes K with a subscript.
function lowerIndices(svg) {
  for (const text of svg.querySelectorAll('text')) {
    if (text.children.length > 0 || !/[A-Za-z]_[A-Za-z0-9]/.test(text.textContent)) continue;
    const parts = text.textContent.split(/(?<=\b[A-Za-z])_([A-Za-z0-9]+)/);
    text.textContent = '';
    parts.forEach((part, i) => {
      const span = document.createElementNS(svg.namespaceURI, 'tspan');
      span.textContent = part;
      if (i % 2 === 1) span.setAttribute('font-size', '10');
      if (i > 0) span.setAttribute('dy', i % 2 === 1 ? '3' : '-3');
      text.append(span);
    });
  }
}

function save(name, url) {
  const link = document.createElement('a');
  link.download = name;
  link.href = url;
  link.click();
}

function addExports(element, name) {
  const text = () => new XMLSerializer().serializeToString(element.querySelector('svg'));
  const source = () => 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(text());
  const button = (label, act) => {
    const made = document.createElement('button');
    made.textContent = label;
    made.onclick = act;
    return made;
  };
  const bar = document.createElement('div');
  bar.className = 'exports';
  bar.append(button('SVG', () => save(name + '.svg', source())), button('PNG', () => {
    const image = new Image(), scale = 3;
    image.onload = () => {
      const canvas = document.createElement('canvas');
      canvas.width = scale * image.width;
      canvas.height = scale * image.height;
      const context = canvas.getContext('2d');
      context.fillStyle = '#fff';
      context.fillRect(0, 0, canvas.width, canvas.height);
      context.drawImage(image, 0, 0, canvas.width, canvas.height);
      save(name + '.png', canvas.toDataURL('image/png'));
    };
    image.src = source();
  }));
  element.after(bar);
}

async function draw(element) {
  const figure = JSON.parse(document.getElementById(element.id + '-data').textContent);
  let view;
  view = new vega.View(vega.parse(specOf(figure)), {renderer: 'svg', container: element, hover: true,
    tooltip: showTooltip(figure, () => view)});
  await view.runAsync();
  lowerIndices(element.querySelector('svg'));
  addExports(element, element.id);
}

Promise.all([...document.querySelectorAll('figure > .plot')].map(draw)).then(
  () => { document.body.dataset.ready = 'yes'; },
  error => { document.body.dataset.error = error.stack; throw error; });
