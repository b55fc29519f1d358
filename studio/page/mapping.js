// Which column holds which signal, chosen by hand.

/** Writes what was chosen to the machine file, where there is one. */
async function writeMaps() {
  if (drive.text.trim() && (maps.size || unused.size)) {
    drive.text = await engine.call('mapped', [request()]);
    maps.clear();
    unused.clear();
  }
  await check();
}

/** What a column is taken for before anything is chosen. */
const signalOf = (column) => column.read_as ?? (column.unused ? '' : column.guess ?? '');

function whyOf(column) {
  if (column.read_as) return 'read so';
  if (column.unused) return 'left unused';
  return column.guess ? `guessed: ${column.why}` : 'not used';
}

/** A row of the table: the column, a choice of its signal, and why that is preselected. */
function columnRow(column, signals) {
  const before = signalOf(column);
  const options = ['', ...signals].map((signal) => element('option', { value: signal, textContent: signal || '–', selected: signal === before }));
  const choice = element('select', { ariaLabel: `signal of ${column.header}` }, ...options);
  Object.assign(choice.dataset, { header: column.header, before, read: column.read_as ?? '' });
  return element('tr', {}, element('td', { textContent: column.header }), element('td', {}, choice), element('td', { className: 'soft', textContent: whyOf(column) }));
}

/** Keeps what the choices say: a signal maps its column, and – leaves one unused that had or might have had a signal. */
function keepChoices(choices) {
  for (const { value, dataset: { header, before, read } } of choices) {
    if (value && value !== read) {
      maps.set(value, header);
      unused.delete(header);
    } else if (!value && before) {
      [...maps].filter(([, mapped]) => mapped === header).forEach(([signal]) => maps.delete(signal));
      unused.add(header);
    }
  }
}

async function writeChoices(choices) {
  refuse();
  const chosen = choices.filter(({ value }) => value);
  const twice = chosen.find(({ value }, index) => chosen.findIndex((other) => other.value === value) < index);
  if (twice) {
    const both = chosen.filter(({ value }) => value === twice.value).map(({ dataset }) => dataset.header);
    return refuse(`${twice.value}: chosen for ${both.join(' and ')}; expected one column for each signal`);
  }
  keepChoices(choices);
  try {
    await writeMaps();
  } catch (error) {
    maps.clear();
    unused.clear();
    refuse(error.message);
  }
}

/** How often the table of columns was asked for: an older answer shows nothing. */
let asks = 0;

/** A table of all columns, each with the signal that it is read as, and a choice. */
async function showColumns() {
  const place = byId('columns');
  if (!byId('mapping').open) return;
  const ask = ++asks;
  const { signals } = JSON.parse(await engine.call('columns', [JSON.stringify({ machine: null, train: [] })]));
  const files = await Promise.all([...recordings.keys()].map(surveyed));
  if (ask !== asks) return;
  const seen = new Map();
  files.forEach(({ columns }) => columns.forEach((column) => seen.has(column.header) || seen.set(column.header, column)));
  const rows = [...seen.values()].map((column) => columnRow(column, signals));
  const write = () => writeChoices([...place.querySelectorAll('select')]);
  const button = element('button', { type: 'button', id: 'write-map', textContent: 'Write to the machine file', onclick: write });
  place.replaceChildren(...(rows.length ? [table(['column', 'signal', ''], rows), element('p', {}, button)] : [element('p', { textContent: 'No recording yet.' })]));
}

function listenForMapping() {
  byId('mapping').ontoggle = showColumns;
  listeners.push(showColumns);
}
