// The drive: its machine file as text, from a data sheet's form, and with columns mapped by hand.

function showDrive() {
  const text = drive.text.trim();
  const name = /^name\s*=\s*"(.*)"/m.exec(drive.text)?.[1];
  byId('drive').textContent = text ? `${drive.name}${name ? `: ${name}` : ''}` : 'No machine file yet: drop one, or fill in the data sheet.';
  const field = byId('machine');
  // What somebody is typing stays.
  if (field.value !== drive.text && document.activeElement !== field) field.value = drive.text;
  byId('save-machine').disabled = !text;
}

/** The form of the data sheet, from the table of `host-sim init`. */
function showForm() {
  const source = element('select', { ariaLabel: 'What feeds the cylinder' },
    element('option', { value: 'of_valve', textContent: 'a servo or proportional valve' }),
    element('option', { value: 'of_pump', textContent: 'a pump, directly' }));
  const called = element('input', { placeholder: 'press' });
  const over = element('input', { type: 'checkbox' });
  const fields = engine.questions.map((question) => {
    const input = element('input', { name: question.flag, placeholder: question.example });
    const need = question.otherwise ? `without it: ${question.otherwise}` : question.need;
    const label = element('label', {}, question.what, element('span', { className: 'soft', textContent: need }), input);
    return { question, input, label };
  });
  const choose = () => fields.forEach(({ question, label }) => { label.hidden = label.style.display = question[source.value] ? '' : 'none'; });
  source.onchange = choose;
  choose();
  const make = async (event) => {
    event.preventDefault();
    refuse();
    const given = fields.filter(({ question }) => question[source.value]).map(({ input }) => [input.name, input.value]);
    const name = called.value.trim() || called.placeholder;
    const form = { name, over_both_edges: over.checked, answers: Object.fromEntries(given) };
    try {
      Object.assign(drive, { name: 'machine.toml', text: await engine.call('machine_of_sheet', [JSON.stringify(form)]) });
      told.textContent = '';
      byId('text').open = true;
      await writeMaps();
    } catch (error) {
      told.textContent = error.message;
    }
  };
  const told = element('p', { className: 'problem' });
  byId('form').replaceChildren(
    element('p', {}, element('label', {}, 'What feeds the cylinder? ', source)),
    element('div', { className: 'fields' }, element('label', {}, 'Name of the drive', called), ...fields.map(({ label }) => label)),
    element('p', {}, element('label', {}, over, ' The rated pressure drop stands over both edges in series')),
    element('p', {}, element('button', { textContent: 'Make the machine file' })), told);
  byId('form').onsubmit = make;
}

/** Writes columns mapped by hand to the machine file, where there is one. */
async function writeMaps() {
  if (drive.text.trim() && maps.size) {
    drive.text = await engine.call('mapped', [request()]);
    maps.clear();
  }
  await check();
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
  const rows = [...seen.values()].map((column) => {
    const options = ['', ...signals].map((signal) => element('option', { value: signal, textContent: signal || '–', selected: signal === (column.read_as ?? column.guess ?? '') }));
    const choice = element('select', { ariaLabel: `signal of ${column.header}` }, ...options);
    choice.dataset.header = column.header;
    choice.dataset.before = column.read_as ?? '';
    const why = column.read_as ? 'read so' : column.guess ? `guessed: ${column.why}` : 'not used';
    return element('tr', {}, element('td', { textContent: column.header }), element('td', {}, choice), element('td', { className: 'soft', textContent: why }));
  });
  const write = async () => {
    refuse();
    const chosen = [...place.querySelectorAll('select')].filter(({ value }) => value);
    const twice = chosen.find(({ value }, index) => chosen.findIndex((other) => other.value === value) < index);
    if (twice) {
      const both = chosen.filter(({ value }) => value === twice.value).map(({ dataset }) => dataset.header);
      return refuse(`${twice.value}: chosen for ${both.join(' and ')}; expected one column for each signal`);
    }
    chosen.filter(({ value, dataset }) => value !== dataset.before).forEach(({ value, dataset }) => maps.set(value, dataset.header));
    try {
      await writeMaps();
    } catch (error) {
      maps.clear();
      refuse(error.message);
    }
  };
  const button = element('button', { type: 'button', id: 'write-map', textContent: 'Write to the machine file', onclick: write });
  place.replaceChildren(...(rows.length ? [table(['column', 'signal', ''], rows), element('p', {}, button)] : [element('p', { textContent: 'No recording yet.' })]));
}

function listenForMachine() {
  byId('machine').onchange = ({ target }) => { drive.text = target.value; check(); };
  byId('save-machine').onclick = () => save(drive.name, 'application/toml', drive.text);
  byId('mapping').ontoggle = showColumns;
  listeners.push(showDrive, showColumns);
}
